"""Rate limits: token buckets. Pure."""

from __future__ import annotations


class TokenBucket:
    """Allows `burst` at once and `rate_hz` a second in the long run."""

    def __init__(self, *, rate_hz: float, burst: int, now_s: float) -> None:
        self._rate_hz = rate_hz
        self._burst = burst
        self._tokens = float(burst)
        self._filled_s = now_s

    def take(self, now_s: float) -> bool:
        """Take one token; False if there is none. A clock that runs backwards adds none."""
        gained = max(now_s - self._filled_s, 0.0) * self._rate_hz
        self._filled_s = max(self._filled_s, now_s)
        self._tokens = min(self._tokens + gained, float(self._burst))
        if self._tokens < 1:
            return False
        self._tokens -= 1
        return True


class TokenBuckets:
    """A token bucket for each key; beyond `most` keys the least recently used is dropped."""

    def __init__(self, *, rate_hz: float, burst: int, most: int) -> None:
        self._rate_hz = rate_hz
        self._burst = burst
        self._most = most
        self._buckets: dict[str, TokenBucket] = {}

    def take(self, key: str, now_s: float) -> bool:
        """Take one of this key's tokens; False if there is none."""
        bucket = self._buckets.pop(key, None)
        if bucket is None:
            bucket = TokenBucket(rate_hz=self._rate_hz, burst=self._burst, now_s=now_s)
        self._buckets[key] = bucket
        if len(self._buckets) > self._most:
            del self._buckets[next(iter(self._buckets))]
        return bucket.take(now_s)
