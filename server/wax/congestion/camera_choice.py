"""Chooses what is sent of the cameras beside the driving view: of what that one leaves. Pure.

The driving view is decided as if there were no others (`wax.congestion.allocator`). They get the
rest, the large one first; where the rest shrinks they go first, at once. They come back when they
have fitted for a while, longer each time that was too early.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from wax.congestion.allocator import Since
from wax.congestion.wire_cost import picture_bps

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.congestion.allocation import Step

_HOLD_S: Final = 1.0
"""More must have fitted for this long. Ours, as the driving view's."""

_TRIAL_S: Final = 8.0
"""More that is taken back within this time was too much. Ours, as the driving view's."""

_FAILED_HOLD_S: Final = 5.0
"""Then it must fit for this long, and twice as long after each further failure. Ours."""

_MAX_HOLD_S: Final = 60.0
"""At most. Ours."""


class CameraChoice:
    """Chooses a step for each camera of one viewer; `now_s` never falls."""

    def __init__(self) -> None:
        self._now_s = -math.inf
        self._rose_s = -math.inf
        self._hold_s = _HOLD_S
        self._better = Since()
        self._wished: list[list[Step]] = []
        self._chosen: list[Step | None] = []

    def decide(
        self,
        wishes: Sequence[Sequence[Step]],
        *,
        left_bps: float,
        kept_bps: float,
        rate_bps: float,
        now_s: float,
    ) -> list[Step | None]:
        """Return the step of each camera, None for nothing.

        `wishes` has for each the steps that are welcome, the best first; none for a camera that
        nobody looks at. The more important camera has more of them. New steps begin if all fit in
        `left_bps`, and go on while all fit in `kept_bps`; the wire's rate is `rate_bps`.
        """
        if self._now_s < now_s < math.inf:
            self._now_s = now_s
        best = _filled(wishes, left_bps, rate_bps)
        if len(wishes) != len(self._chosen):
            self._chosen = [None] * len(wishes)
        if [list(one) for one in wishes] != self._wished:
            # Who looks at something else need not wait, unless more has just been too much.
            self._wished = [list(one) for one in wishes]
            is_doubtful = self._hold_s > _HOLD_S
            most_bps = _cost(self._chosen, rate_bps) if is_doubtful else left_bps
            self._chosen = _filled(wishes, most_bps, rate_bps)
        if _cost(self._chosen, rate_bps) > max(kept_bps, 0.0):
            self._failed()
            self._chosen = _filled(wishes, min(left_bps, kept_bps), rate_bps)
        more = _cost(best, rate_bps) > _cost(self._chosen, rate_bps)
        if self._better.lasts(more, self._hold_s, self._now_s):
            self._chosen, self._rose_s = best, self._now_s
        elif -math.inf < self._rose_s < self._now_s - _TRIAL_S:
            self._hold_s = _HOLD_S
        return list(self._chosen)

    def _failed(self) -> None:
        if self._now_s - self._rose_s < _TRIAL_S:
            self._hold_s = min(max(2 * self._hold_s, _FAILED_HOLD_S), _MAX_HOLD_S)
        self._rose_s = -math.inf


def _filled(
    wishes: Sequence[Sequence[Step]], left_bps: float, rate_bps: float
) -> list[Step | None]:
    """Give each its least step, the more important first; what is left goes to better ones."""
    chosen: list[Step | None] = [None] * len(wishes)
    order = sorted(range(len(wishes)), key=lambda at: -len(wishes[at]))
    for at in order:
        if wishes[at] and (cost := picture_bps(wishes[at][-1], 0, rate_bps)) <= left_bps:
            chosen[at] = wishes[at][-1]
            left_bps -= cost
    for at in order:
        least = chosen[at]
        if least is None:
            continue
        more_bps = left_bps + picture_bps(least, 0, rate_bps)
        step = next(one for one in wishes[at] if picture_bps(one, 0, rate_bps) <= more_bps)
        left_bps = more_bps - picture_bps(step, 0, rate_bps)
        chosen[at] = step
    return chosen


def _cost(chosen: Sequence[Step | None], rate_bps: float) -> float:
    return sum(picture_bps(one, 0, rate_bps) for one in chosen if one is not None)
