"""Which sizes of the picture are left while this machine does not encode them in time. Pure.

Another program or heat may slow a machine down that passed its trial at the start. A picture that
takes longer to encode than its frame interval delays and drops the next ones; a smaller one is
fluent. Cameras beside the driving view leave their largest sizes first, whichever is late.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from wax.congestion.allocation import area
from wax.congestion.upgrade_backoff import Since

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

BESIDE: Final = "beside"
"""The largest sizes of all cameras beside the driving view, which are left together."""
_LATE_SHARE: Final = 0.9
"""Encoding falls behind if it takes more than this part of the frame interval."""
_LATE_S: Final = 3.0
"""A size is left after this long: keyframes and short bursts of other work pass."""
_PAUSE_S: Final = 30.0
"""A size is tried again after this long, and after twice as long each time it fails."""
_MAX_PAUSE_S: Final = 960.0
"""Each trial in vain is some seconds of stutter; heat and other programs last for longer."""
_TRIAL_S: Final = 60.0
"""A size that is left again within this time has failed."""


class LateEncoding:
    """Call `update` about once a second; `now_s` never falls."""

    def __init__(self, sizes: Iterable[str], *, has_cameras: bool = False) -> None:
        """Take the driving view's sizes; raise ValueError for an invalid one."""
        own = sorted(set(sizes), key=area, reverse=True)
        self._sizes = [BESIDE, *own] if has_cameras else own
        self._left = 0
        self._late = Since()
        self._pause_s = _PAUSE_S
        self._changed_s = self._tried_s = -math.inf

    @property
    def left(self) -> list[str]:
        """The sizes that nobody is sent, `BESIDE` and then the largest first; never all."""
        return self._sizes[: self._left]

    @property
    def leaves_beside(self) -> bool:
        """Whether the other cameras' largest sizes are left."""
        return BESIDE in self.left

    def bounded(self, size: str) -> str:
        """Return this size, or the largest that is sent if this one is larger."""
        most = self._sizes[self._left]
        return min(size, most, key=area) if self._left else size

    def update(self, loads: Mapping[str, float], now_s: float) -> None:
        """Take how much of its frame interval each size's encoder needs; 0 while it rests."""
        used = [at for at in range(self._left, len(self._sizes)) if self._load(loads, at) > 0]
        top = used[0] if used else self._left
        judged = used[:2] if self._sizes[top] == BESIDE else used[:1]
        is_late = any(self._load(loads, at) > _LATE_SHARE for at in judged)
        if self._late.lasts(is_late and top < len(self._sizes) - 1, _LATE_S, now_s):
            self._back_off(now_s)
            self._left = self._next_in_time(self._load(loads, top), top)
            self._changed_s, self._late = now_s, Since()
        elif self._left and now_s - self._changed_s >= self._pause_s:
            self._try(self._load(loads, self._left - 1), now_s)

    def _try(self, load: float, now_s: float) -> None:
        # A tape may have the size encoded all the time, which shows that it is still too slow.
        if load <= _LATE_SHARE:
            self._left -= 1
            self._changed_s = self._tried_s = now_s

    def _next_in_time(self, load: float, top: int) -> int:
        """Return the largest smaller size that should be in time; the work grows with the area."""
        at = top + 1
        if self._sizes[top] == BESIDE:
            return at
        share = load / area(self._sizes[top])
        while at < len(self._sizes) - 1 and share * area(self._sizes[at]) > _LATE_SHARE:
            at += 1
        return at

    def _back_off(self, now_s: float) -> None:
        if now_s - self._tried_s < _TRIAL_S:
            self._pause_s = min(2 * self._pause_s, _MAX_PAUSE_S)
        elif now_s - self._changed_s >= _TRIAL_S:
            self._pause_s = _PAUSE_S
        self._tried_s = -math.inf

    def _load(self, loads: Mapping[str, float], at: int) -> float:
        return loads.get(self._sizes[at], 0.0)
