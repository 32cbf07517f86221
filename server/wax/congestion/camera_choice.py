"""Chooses what is sent of the cameras beside the driving view: of what that one leaves. Pure.

The driving view is decided as if there were no others (`wax.congestion.allocator`). They get the
rest, the large one first; where the rest shrinks they go first, at once. They come back when they
have fitted for a while, longer each time that was too early.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from wax.congestion.upgrade_backoff import Since, Trials
from wax.congestion.wire_cost import picture_bps

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.congestion.allocation import Step


class CameraChoice:
    """Chooses a step for each camera of one viewer; `now_s` never falls."""

    def __init__(self) -> None:
        self._now_s = -math.inf
        self._trials = Trials()
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

        `wishes` has the welcome steps of each camera, always of all, the best first; none if nobody
        looks at it. The more important camera has more of them. New steps begin if all fit in
        `left_bps`, and go on while all fit in `kept_bps`; the wire's rate is `rate_bps`.
        """
        if self._now_s < now_s < math.inf:
            self._now_s = now_s
        best = _filled(wishes, left_bps, rate_bps)
        if [list(one) for one in wishes] != self._wished:
            # Who looks at something else need not wait, unless more has just been too much.
            self._wished = [list(one) for one in wishes]
            most_bps = _cost(self._chosen, rate_bps) if self._trials.is_doubtful else left_bps
            self._chosen = _filled(wishes, most_bps, rate_bps)
        if _cost(self._chosen, rate_bps) > max(kept_bps, 0.0):
            self._trials.fell(self._now_s)
            self._chosen = _filled(wishes, min(left_bps, kept_bps), rate_bps)
        more = _cost(best, rate_bps) > _cost(self._chosen, rate_bps)
        self._trials.follow(self._now_s)
        if self._better.lasts(more, self._trials.hold_s, self._now_s):
            self._chosen = best
            self._trials.rose(self._now_s)
        return list(self._chosen)


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
        if (least := chosen[at]) is not None:
            more_bps = left_bps + picture_bps(least, 0, rate_bps)
            step = next(one for one in wishes[at] if picture_bps(one, 0, rate_bps) <= more_bps)
            left_bps = more_bps - picture_bps(step, 0, rate_bps)
            chosen[at] = step
    return chosen


def _cost(chosen: Sequence[Step | None], rate_bps: float) -> float:
    return sum(picture_bps(one, 0, rate_bps) for one in chosen if one is not None)
