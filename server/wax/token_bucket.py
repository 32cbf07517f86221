"""Rate limits: token buckets. Pure."""

from __future__ import annotations

from wax.bounded_dict import BoundedDict


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
