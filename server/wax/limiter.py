"""How many messages a page may send: a token bucket. Pure."""

from __future__ import annotations


class TokenBucket:
    """Lets `burst` through at once and `rate_hz` a second in the long run."""

    def __init__(self, *, rate_hz: float, burst: int, now_s: float) -> None:
        self._rate_hz = rate_hz
        self._burst = burst
        self._tokens = float(burst)
        self._filled_s = now_s

    def take(self, now_s: float) -> bool:
        """Take one token; False where there is none. Time that runs back fills nothing."""
        gained = max(now_s - self._filled_s, 0.0) * self._rate_hz
        self._filled_s = max(self._filled_s, now_s)
        self._tokens = min(self._tokens + gained, float(self._burst))
        if self._tokens < 1:
            return False
        self._tokens -= 1
        return True
