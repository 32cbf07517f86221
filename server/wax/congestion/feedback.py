"""Transport-wide feedback: which packets request it, and whether it is overdue. Pure.

A packet without a transport-wide sequence number gets no feedback. Each feedback packet costs the
browser's uplink about 75 bytes, up to twenty times a second (a tenth of a modem line), and the
server as much as sending four packets. To spare both, settled links are only sampled.
"""

from __future__ import annotations

import math
from collections import deque
from statistics import median_high
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from wax.congestion.control import LinkEstimate

_WINDOW_S: Final = 0.03
"""Length of a sample: one picture and the sound sent with it."""
_SETTLED_EVERY_S: Final = 0.4
"""Interval of samples on a settled link: two of them find a queue."""
_THIN_EVERY_S: Final = 0.5
"""Interval of samples on a thin link, where feedback takes a noticeable share."""
_THIN_BPS: Final = 150_000.0
"""Below this rate a link is only sampled: full feedback takes 8 % of an equally thin uplink."""
_SETTLED_QUEUE_MS: Final = 30.0
"""Longest queue of a settled link; equals the threshold of a standing queue."""
_SPARE_FACTOR: Final = 1.5
"""A settled link carries more than this multiple of the rate in use."""
_SOUND_EVERY_FACTOR: Final = 2.0
"""Sound starts a sample only if no picture has for this multiple of the interval."""
_MIN_TIMEOUT_S: Final = 0.5
"""Shortest timeout; browsers send feedback every 50 to 100 ms. The circuit breaker of RFC 8083
waits for three RTCP intervals, which takes seconds; a robot drives meanwhile."""
_FIRST_TIMEOUT_S: Final = 2.0
"""Timeout for the first feedback, before which no round trip is known."""
_ROUND_TRIPS: Final = 2.0
"""Timeout in round trips: one for the feedback, another to allow for a queue."""
_IDLE_S: Final = 3.0
"""Feedback is not overdue longer than this after the last packet that has any: that packet may be
lost or unmarked."""
_KEPT_ROUND_TRIPS: Final = 5
"""The median of this many round trips is used, so that one lengthened by a queue does not count."""
_MAX_ROUND_TRIP_S: Final = 10.0
"""A longer round trip is clamped to this, against invalid measurements."""


class FeedbackSampling:
    """Opens sample windows; a picture that begins in a window is marked to its end."""

    def __init__(self) -> None:
        self._every_s = 0.0
        self._opened_s = -math.inf
        self._train: tuple[int, bool] | None = None

    @property
    def is_sparse(self) -> bool:
        """Whether only samples are marked, so that feedback may take long."""
        return self._every_s > 0

    def choose_interval(self, estimate: LinkEstimate, *, full_feedback: bool) -> None:
        """Choose the interval for this link; with `full_feedback`, only a thin link is sampled."""
        if estimate.state != "steady":
            self._every_s = 0.0  # every packet must be reported
        elif estimate.rate_bps < _THIN_BPS:
            self._every_s = _THIN_EVERY_S
        else:
            has_room = estimate.rate_bps > _SPARE_FACTOR * estimate.used_bps
            is_settled = has_room and estimate.queue_ms < _SETTLED_QUEUE_MS
            self._every_s = _SETTLED_EVERY_S if is_settled and not full_feedback else 0.0

    def requests_feedback(self, train: int | None, now_s: float) -> bool:
        if train is not None and self._train is not None and train == self._train[0]:
            return self._train[1]
        # Pictures probe the link; sound opens a window only if there are none.
        every_s = self._every_s if train is not None else _SOUND_EVERY_FACTOR * self._every_s
        if now_s - self._opened_s >= every_s:
            self._opened_s = now_s
        is_open = self._every_s == 0.0 or now_s - self._opened_s < _WINDOW_S
        if train is not None:
            self._train = (train, is_open)
        return is_open


class FeedbackTimeout:
    """Detects overdue feedback; times in seconds that never fall."""

    def __init__(self) -> None:
        self._round_trips_s: deque[float] = deque(maxlen=_KEPT_ROUND_TRIPS)
        self._unanswered_s: float | None = None
        self._sent_s = math.inf
        self._heard_s: float | None = None

    @property
    def round_trip_ms(self) -> float | None:
        """The median of the last five round trips, None before the first."""
        return median_high(self._round_trips_s) * 1000 if self._round_trips_s else None

    def round_trip(self, round_trip_s: float) -> None:
        if 0 <= round_trip_s < math.inf:
            self._round_trips_s.append(min(round_trip_s, _MAX_ROUND_TRIP_S))

    def sent(self, now_s: float) -> None:
        if self._unanswered_s is None or self.is_idle(now_s):
            self._unanswered_s = now_s
        self._sent_s = now_s

    def feedback_arrived(self, now_s: float) -> float:
        """Record that feedback has arrived; return the time since the last, 0 for the first."""
        silent_s = 0.0 if self._heard_s is None else now_s - self._heard_s
        self._unanswered_s = None
        self._heard_s = now_s
        return silent_s

    def is_idle(self, now_s: float) -> bool:
        """Return whether nothing was sent for `_IDLE_S`, so that no feedback is due."""
        return now_s - self._sent_s > _IDLE_S

    def is_over(self, now_s: float) -> bool:
        """Return whether feedback is missing for two round trips, and at least half a second."""
        if self._unanswered_s is None or self.is_idle(now_s):
            return False
        longest_s = max(self._round_trips_s, default=0.0)
        least_s = _FIRST_TIMEOUT_S if self._heard_s is None else _MIN_TIMEOUT_S
        return now_s - self._unanswered_s > max(least_s, _ROUND_TRIPS * longest_s)
