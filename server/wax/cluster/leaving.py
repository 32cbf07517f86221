"""Schedules whom to remove from a room, and when. Pure."""

from __future__ import annotations

from heapq import heappop, heappush
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable


class Leaving:
    """Remembers each person only until their last removal."""

    def __init__(self) -> None:
        self._heap: list[tuple[float, str]] = []
        self._last_s: dict[str, float] = {}

    def __len__(self) -> int:
        return len(self._last_s)

    def add(self, person: str, at_s: Iterable[float]) -> None:
        """Schedule a removal of somebody at each of these times."""
        for one_s in at_s:
            heappush(self._heap, (one_s, person))
            self._last_s[person] = max(one_s, self._last_s.get(person, one_s))

    def cancel(self, person: str) -> None:
        """Cancel somebody's removals."""
        self._last_s.pop(person, None)

    def due(self, now_s: float) -> str | None:
        """Pop and return somebody to remove now; None if there is nobody."""
        while self._heap and self._heap[0][0] <= now_s:
            at_s, person = heappop(self._heap)
            last_s = self._last_s.get(person)
            if last_s is not None:
                if at_s >= last_s:
                    del self._last_s[person]
                return person
        return None
