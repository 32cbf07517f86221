"""How much a page's counter has grown in the last minute. Pure."""

from __future__ import annotations

from collections import deque
from typing import Final

_WINDOW_S: Final = 60.0
_EVERY_S: Final = 1.0


class LastMinute:
    """Tracks a counter that only grows, but restarts with each peer."""

    def __init__(self) -> None:
        self._last: float | None = None
        self._grown: deque[tuple[float, float]] = deque()

    def count(self, value: float | None, now_s: float) -> None:
        """Add a reading; None is unknown, and a smaller value than before means a restart."""
        if value is not None:
            grown = 0.0 if self._last is None else max(value - self._last, 0.0)
            self._last = value
            if self._grown and now_s - self._grown[-1][0] < _EVERY_S:
                self._grown[-1] = (self._grown[-1][0], self._grown[-1][1] + grown)
            else:
                self._grown.append((now_s, grown))
        while self._grown and self._grown[0][0] < now_s - _WINDOW_S:
            self._grown.popleft()

    @property
    def sum(self) -> float:
        """How much it has grown, as of the last `count`."""
        return sum(grown for _, grown in self._grown)
