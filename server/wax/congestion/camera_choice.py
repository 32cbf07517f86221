"""Chooses the steps of the additional cameras, from the rate that the driving view leaves. Pure.

The driving view is chosen as if there were no other camera (`wax.congestion.allocator`). The others
share the rest, the one shown large first; when the rest shrinks they are dropped at once. They
return once they have fitted for a while, which grows with each return that was too early.
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

        `wishes` lists each camera's acceptable steps, the best first; the list is empty if the
        viewer does not watch it, and the longer, the more important the camera is. New steps start
        if all fit in `left_bps`, and continue while all fit in `kept_bps`; the link's rate is
        `rate_bps`.
        """
        if self._now_s < now_s < math.inf:
            self._now_s = now_s
        best = _filled(wishes, left_bps, rate_bps)
        if [list(one) for one in wishes] != self._wished:
            # A viewer who changes cameras need not wait, unless an upgrade has just failed.
            self._wished = [list(one) for one in wishes]
            most_bps = _cost(self._chosen, rate_bps) if self._trials.is_doubtful else left_bps
            self._chosen = _filled(wishes, most_bps, rate_bps)
        if _cost(self._chosen, rate_bps) > max(kept_bps, 0.0):
            self._trials.record_downgrade(self._now_s)
            self._chosen = _filled(wishes, min(left_bps, kept_bps), rate_bps)
        more = _cost(best, rate_bps) > _cost(self._chosen, rate_bps)
        self._trials.settle(self._now_s)
        if self._better.lasts(more, self._trials.hold_s, self._now_s):
            self._chosen = best
            self._trials.record_upgrade(self._now_s)
        return list(self._chosen)


def _filled(
    wishes: Sequence[Sequence[Step]], left_bps: float, rate_bps: float
) -> list[Step | None]:
    """Give each camera its smallest step, the most important first; then upgrade with the rest."""
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
