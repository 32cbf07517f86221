"""Rate limits: token buckets, so many within a minute, and the last of many requests. Pure."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Final, Generic, TypeVar

from wax.bounded_dict import BoundedDict

if TYPE_CHECKING:
    from collections.abc import Callable

_MINUTE_S: Final = 60.0

_T = TypeVar("_T")


class TokenBucket:
    """Allows `burst` at once, as it is full at first, and `rate_hz` a second in the long run."""

    def __init__(self, rate_hz: float, burst: float) -> None:
        self._rate_hz = rate_hz
        self._burst = burst
        self._tokens = burst
        self._filled_s = 0.0

    def level(self, now_s: float) -> float:
        """Return how many tokens there are; a clock that runs backwards adds none."""
        if now_s > self._filled_s:
            gained = (now_s - self._filled_s) * self._rate_hz
            self._tokens = min(self._tokens + gained, self._burst)
            self._filled_s = now_s
        return self._tokens

    def take(self, now_s: float) -> bool:
        """Take one token; False if there is none."""
        if self.level(now_s) < 1:
            return False
        self._tokens -= 1
        return True

    def owe(self, tokens: float) -> None:
        """Take so many whether there are any; the debt is never more than a second fills."""
        self._tokens = max(self._tokens - tokens, -self._rate_hz)

    def recovers_in_s(self, now_s: float) -> float:
        """Return in how long the debt is paid."""
        return max(-self.level(now_s), 0.0) / self._rate_hz


class TokenBuckets:
    """A token bucket for each key; beyond `most` keys the least recently used is dropped."""

    def __init__(self, *, rate_hz: float, burst: float, most: int) -> None:
        self._rate_hz = rate_hz
        self._burst = burst
        self._buckets = BoundedDict[str, TokenBucket](most)

    def take(self, key: str, now_s: float) -> bool:
        """Take one of this key's tokens; False if there is none."""
        bucket = self._buckets.get(key) or TokenBucket(self._rate_hz, self._burst)
        self._buckets[key] = bucket
        return bucket.take(now_s)


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


class LastWins(Generic[_T]):
    """Calls `do` with requests as often as `allowed`; the last one is never lost."""

    def __init__(self, do: Callable[[_T], None], allowed: TokenBucket) -> None:
        self._do = do
        self._allowed = allowed
        self._waiting: list[_T] = []

    def submit(self, request: _T, now_s: float) -> None:
        """Run the request now, or later in place of one that still waits."""
        self._waiting = [request]
        self.run_waiting(now_s)

    @property
    def is_waiting(self) -> bool:
        return bool(self._waiting)

    def run_waiting(self, now_s: float) -> None:
        """Run the waiting request if the rate allows it by now."""
        if self._waiting and self._allowed.take(now_s):
            self._do(self._waiting.pop())
