"""Shares what the robot can send among its viewers: the operator first, all others equally. Pure.

Max-min fairness by filling (Bertsekas and Gallager, Data Networks, 6.5.2): no observer gets more
than another who wants more, and no wanted capacity stays unused.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.rate_limits import TokenBucket

if TYPE_CHECKING:
    from collections.abc import Hashable

_MEDIA_SHARE: Final = 0.9
"""Share of the upload for media; the rest is for retransmissions, keyframes and the page."""
_REPEAT_SHARE: Final = 0.05
"""Share of the upload for retransmissions: half of that rest. Bursts of up to a second's worth are
allowed."""
_FILL_S: Final = 0.1
"""How long a level is kept while nobody joins, leaves or starts to drive: as long as estimates."""


class UploadBudget:
    """`upload_bps` is shared by all viewers; 0 means no limit. `who` is any key for a viewer."""

    def __init__(self, upload_bps: float) -> None:
        self._all_bps = _MEDIA_SHARE * upload_bps if upload_bps > 0 else float("inf")
        self._observers_bps = float("inf")
        repeat_bps = _REPEAT_SHARE * upload_bps if upload_bps > 0 else float("inf")
        self._repeats = TokenBucket(repeat_bps, repeat_bps)
        self._wants: dict[Hashable, tuple[float, bool]] = {}  # how much, and whether they drive
        self._level_bps = self._all_bps
        self._filled_s = float("-inf")

    def share_bps(self, who: Hashable, wants_bps: float, *, drives: bool, now_s: float) -> float:
        """Return how much of what one viewer wants they may be sent from now on."""
        _, drove = self._wants.get(who, (0.0, None))
        self._wants[who] = wants_bps, drives
        if drove != drives or not 0 <= now_s - self._filled_s < _FILL_S:
            self._filled_s = now_s
            self._level_bps = self._level(self._observers_bps)
        return min(wants_bps, self._all_bps if drives else self._level_bps)

    def may_repeat(self, size_bytes: int, *, drives: bool, now_s: float) -> bool:
        """Admit and count a retransmission if there is budget; always admit the operator's."""
        if self._repeats.level(now_s) < 0 and not drives:
            return False
        self._repeats.owe(8 * size_bytes)
        return True

    def limit_observers(self, most_bps: float) -> None:
        """Send all observers together no more than this from now on."""
        self._observers_bps = most_bps
        self._filled_s = float("-inf")

    @property
    def observers_want_bps(self) -> list[float]:
        """What each observer's link would carry."""
        return [bps for bps, drives in self._wants.values() if not drives]

    def leave(self, who: Hashable) -> None:
        """Release a viewer's share to the others; safe to call twice."""
        if self._wants.pop(who, None) is not None:
            self._filled_s = float("-inf")

    def next_bps(self) -> float:
        """Return what one more observer without an upper limit would get."""
        return self._level(float("inf"), float("inf"))

    def _level(self, most_bps: float, *more_bps: float) -> float:
        """Return the max-min fair level: the most that an observer gets of what is left."""
        driven_bps = sum(bps for bps, drives in self._wants.values() if drives)
        left_bps = min(max(self._all_bps - driven_bps, 0.0), most_bps)
        wants_bps = [*self.observers_want_bps, *more_bps]
        for served, bps in enumerate(sorted(wants_bps)):
            waiting = len(wants_bps) - served
            if bps * waiting >= left_bps:
                return left_bps / waiting
            left_bps -= bps
        return float("inf")
