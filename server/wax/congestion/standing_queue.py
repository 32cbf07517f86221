"""Whether the queue of a link stands: nothing comes any more that has not waited."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from wax.congestion.queuing_delay import QueuingDelay

_STANDING_S: Final = 0.030
_PACKETS: Final = 1.5
_PACKET_BITS: Final = 8 * 250
_SPAN_S: Final = 0.040
_ROUGH: Final = 3.0
_MOST_ROUGH_S: Final = 0.060
_CERTAIN: Final = 2.5
_LEVEL_S: Final = 0.020
_GONE: Final = 0.6


class StandingQueue:
    """Entered when seen twice, or once where it is long; left when it is nearly gone."""

    def __init__(self) -> None:
        self._seen = 0
        self.since_s: float | None = None
        """When it was found; None while there is none."""
        self._level_s = 0.0
        self._level_from_s = 0.0

    def look(self, waiting: QueuingDelay, rate_bps: float, now_s: float) -> bool:
        """Judge after each feedback; return whether the queue stands."""
        limit_s = self.limit_s(waiting, rate_bps)
        standing_s = waiting.standing_s
        if abs(standing_s - self._level_s) > _LEVEL_S:
            self._level_s, self._level_from_s = standing_s, now_s
        if self.since_s is not None:
            if standing_s < _GONE * limit_s:
                self.since_s = None
                self._seen = 0
        elif standing_s <= limit_s:
            self._seen = 0
        elif waiting.span_s >= _SPAN_S:
            self._seen += 1
            if self._seen >= 2 or standing_s > _CERTAIN * limit_s:
                self.since_s = now_s
        return self.since_s is not None

    def level_for_s(self, now_s: float) -> float:
        """Return for how long the wait has neither grown nor shrunk; a queue does one of both."""
        return now_s - self._level_from_s

    def limit_s(self, waiting: QueuingDelay, rate_bps: float) -> float:
        """Return what is still no queue: one packet before another, and what is jitter."""
        jitter_s = min(_ROUGH * waiting.rough_s, _MOST_ROUGH_S)
        return max(_STANDING_S, _PACKETS * _PACKET_BITS / rate_bps, jitter_s)

    def clear(self) -> None:
        self._seen = 0
        self.since_s = None
