"""Whether feedback is overdue: the RTCP timeout of a circuit breaker (RFC 8083), but sooner."""

from __future__ import annotations

import math
from collections import deque
from typing import Final

_MIN_TIMEOUT_S: Final = 0.5
"""Shortest timeout; browsers send feedback every 50 to 100 ms. RFC 8083 waits for three RTCP
intervals, which takes seconds; a robot drives meanwhile."""
_FIRST_TIMEOUT_S: Final = 2.0
"""Timeout of the first feedback: no round trip is known before it."""
_ROUND_TRIPS: Final = 2.0
"""Feedback takes one round trip; another one is allowed for a queue."""
_IDLE_S: Final = 3.0
"""Nothing is overdue if no packet with feedback was sent for this long: the last packets may have
been lost, or unmarked."""
_KEPT_ROUND_TRIPS: Final = 5
"""The median of this many counts, so that one lengthened by a queue does not."""
_MAX_ROUND_TRIP_S: Final = 10.0
"""A longer one counts as this, against invalid measurements."""


class FeedbackTimeout:
    """Times in seconds that never fall."""

    def __init__(self) -> None:
        self._round_trips_s: deque[float] = deque(maxlen=_KEPT_ROUND_TRIPS)
        self._unanswered_s: float | None = None
        self._sent_s = math.inf
        self._heard_s: float | None = None

    @property
    def round_trip_s(self) -> float | None:
        """The median of the last five, None while none was measured."""
        if not self._round_trips_s:
            return None
        return sorted(self._round_trips_s)[len(self._round_trips_s) // 2]

    def round_trip(self, round_trip_s: float) -> None:
        if 0 <= round_trip_s < math.inf:
            self._round_trips_s.append(min(round_trip_s, _MAX_ROUND_TRIP_S))

    def sent(self, now_s: float) -> None:
        if self._unanswered_s is None or self.is_idle(now_s):
            self._unanswered_s = now_s
        self._sent_s = now_s

    def heard(self, now_s: float) -> float:
        """Note that feedback has come; return how long after the last, 0 for the first."""
        silent_s = 0.0 if self._heard_s is None else now_s - self._heard_s
        self._unanswered_s = None
        self._heard_s = now_s
        return silent_s

    def is_idle(self, now_s: float) -> bool:
        """Return whether nothing was sent for so long that no feedback is due."""
        return now_s - self._sent_s > _IDLE_S

    def is_over(self, now_s: float) -> bool:
        """Return whether it has been missing for two round trips, and at least half a second."""
        if self._unanswered_s is None or self.is_idle(now_s):
            return False
        longest_s = max(self._round_trips_s, default=0.0)
        least_s = _FIRST_TIMEOUT_S if self._heard_s is None else _MIN_TIMEOUT_S
        return now_s - self._unanswered_s > max(least_s, _ROUND_TRIPS * longest_s)
