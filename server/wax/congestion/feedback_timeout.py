"""Whether the browser should have been heard of by now."""

from __future__ import annotations

import math
from collections import deque
from typing import Final

_LEAST_S: Final = 0.5
_FIRST_S: Final = 2.0
_ROUND_TRIPS: Final = 2.0
_KEPT: Final = 5
_MOST_S: Final = 10.0


class FeedbackTimeout:
    """Times in seconds that never fall."""

    def __init__(self) -> None:
        self._round_trips_s: deque[float] = deque(maxlen=_KEPT)
        self._unanswered_s: float | None = None
        self._heard = False

    @property
    def round_trip_s(self) -> float | None:
        """The middle of the last five, None while none was measured."""
        if not self._round_trips_s:
            return None
        return sorted(self._round_trips_s)[len(self._round_trips_s) // 2]

    def round_trip(self, round_trip_s: float) -> None:
        if 0 <= round_trip_s < math.inf:
            self._round_trips_s.append(min(round_trip_s, _MOST_S))

    def sent(self, now_s: float) -> None:
        if self._unanswered_s is None:
            self._unanswered_s = now_s

    def heard(self) -> None:
        self._unanswered_s = None
        self._heard = True

    def lasts_s(self, now_s: float) -> float:
        """Return how long nothing has come although something was sent."""
        return 0.0 if self._unanswered_s is None else max(0.0, now_s - self._unanswered_s)

    def blind(self, now_s: float) -> bool:
        """Tell whether that is longer than two round trips, half a second at least.

        The first feedback may take 2 s: until then no round trip is known.
        """
        longest_s = max(self._round_trips_s, default=0.0)
        allowed_s = max(_LEAST_S if self._heard else _FIRST_S, _ROUND_TRIPS * longest_s)
        return self.lasts_s(now_s) > allowed_s
