"""A limit for each of many keys, within any 60 s. Pure."""

from __future__ import annotations

from collections import deque
from typing import Final

from wax.bounded_dict import BoundedDict

_MINUTE_S: Final = 60.0


class MinuteLimits:
    """Allows each key `each` within any 60 s; beyond `most` keys the least recent is dropped.

    A token bucket of the same numbers would allow twice as many in its first minute.
    """

    def __init__(self, *, each: int, most: int) -> None:
        self._each = each
        self._taken_s = BoundedDict[str, deque[float]](most)

    def take(self, key: str, now_s: float) -> bool:
        """Count one more for this key; False, uncounted, if its limit is reached."""
        if self.taken(key, now_s) >= self._each:
            return False
        taken_s = self._taken_s.get(key) or deque[float]()
        taken_s.append(now_s)
        self._taken_s[key] = taken_s
        return True

    def taken(self, key: str, now_s: float) -> int:
        """Return how many this key has taken within the last minute."""
        taken_s = self._taken_s.get(key, ())
        while taken_s and now_s - taken_s[0] >= _MINUTE_S:
            taken_s.popleft()
        return len(taken_s)
