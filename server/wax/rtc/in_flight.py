"""The packets in flight to one viewer: sent, but without feedback yet. Pure."""

from __future__ import annotations

from bisect import bisect_left
from typing import TYPE_CHECKING, Final, Literal

from wax.congestion.control import Delivery
from wax.rtc.twcc_feedback import PERIOD_S

if TYPE_CHECKING:
    from wax.rtc.twcc_feedback import Feedback

FORGOTTEN_S: Final = 5.0
"""A packet without feedback for this long is forgotten."""

MOST_DELIVERIES: Final = 128
"""Deliveries per feedback: a quarter of a second of the largest rendition, while browsers report
twenty times a second. After a longer outage the newest say as much as all."""

_MOST: Final = 2**15
"""Half of the 16-bit numbers: with more in flight they would be ambiguous."""

_Kind = Literal["audio", "video", "repeat"]
_Sent = tuple[float, int, _Kind, "int | None"]


class InFlight:
    """Numbers packets for transport-wide feedback and matches the feedback with them.

    Internally, numbers and the browser's clock are unwrapped. Memory is bounded by what is sent in
    5 s. A call costs as much as it has arrivals and newly reports or forgets packets; how many
    packets a feedback spans or repeats costs nothing.
    """

    def __init__(self) -> None:
        self._sent: dict[int, _Sent] = {}
        self._untold: list[int] = []
        """Packets not yet reported as arrived or lost, in ascending order."""
        self._oldest = 0
        self._next = 0
        self._ahead = 0  # one past the highest number that has arrived
        self._doubted = range(0)
        """Reported as missing, but nothing later has arrived yet."""
        self._newest_arrived_s: float | None = None

    def sent(self, now_s: float, *, size_bytes: int, kind: _Kind, train: int | None) -> int:
        """Record a packet that leaves now; returns its transport-wide number, 16 bits."""
        self._forget(now_s)
        number = self._next
        self._sent[number] = (now_s, size_bytes, kind, train)
        self._untold.append(number)
        self._next = number + 1
        return number & 0xFFFF

    def reported(self, feedback: Feedback, now_s: float) -> tuple[Delivery, ...]:
        """Return what is new in this feedback, in the order of sending.

        An arrival is reported once. A loss is reported when a later packet has arrived, and may be
        followed by an arrival, because packets can be reordered. `arrived_s` never wraps, though
        the browser's clock does. Of more than `MOST_DELIVERIES` deliveries the newest are returned.
        """
        self._forget(now_s)
        start = self._next + _signed16(feedback.sequence_number - self._next)
        told: list[tuple[int, _Sent, float | None]] = []
        shift_s: float | None = None
        for place, arrived_s in feedback.arrivals:
            sent = self._sent.pop(start + place, None)
            if sent is not None:
                if shift_s is None:
                    shift_s = self._shift_s(arrived_s)
                told.append((start + place, sent, arrived_s + shift_s))
        if told:
            newest, _, self._newest_arrived_s = told[-1]
            self._ahead = max(self._ahead, newest + 1)
        lost = self._newly_lost(range(start, min(start + feedback.packets, self._next)))
        if lost:
            told += [(number, self._sent[number], None) for number in lost]
            told.sort(key=_number)
        return tuple([_delivery(sent, arrived_s) for _, sent, arrived_s in told[-MOST_DELIVERIES:]])

    def forget(self) -> None:
        """Forget all packets in flight; numbering continues."""
        self._sent.clear()
        self._untold.clear()
        self._oldest = self._ahead = self._next
        self._doubted = range(0)

    def oldest_unreported_s(self, now_s: float) -> float | None:
        """Return how long ago the oldest packet in flight left, 5 s at most; None without one."""
        self._forget(now_s)
        if self._ahead == self._next:
            return None
        return now_s - self._sent[self._ahead][0]

    def _shift_s(self, arrived_s: float) -> float:
        """Return the offset in whole periods that puts this time next to earlier ones."""
        if self._newest_arrived_s is None:
            return 0.0
        return round((self._newest_arrived_s - arrived_s) / PERIOD_S) * PERIOD_S

    def _newly_lost(self, reported: range) -> list[int]:
        """Return the packets now known to be lost: missing, while a later one has arrived."""
        lost: list[int] = []
        for some in (reported, self._doubted):
            first = bisect_left(self._untold, some.start)
            last = bisect_left(self._untold, min(some.stop, self._ahead), first)
            lost += [number for number in self._untold[first:last] if number in self._sent]
            del self._untold[first:last]
        rest = range(max(reported.start, self._ahead), reported.stop)
        if rest:  # never by libwebrtc, whose feedback ends with an arrival
            old = self._doubted
            if old.start <= rest.stop and rest.start <= old.stop:
                rest = range(min(old.start, rest.start), max(old.stop, rest.stop))
            self._doubted = rest
        return lost

    def _forget(self, now_s: float) -> None:
        oldest = self._oldest
        self._forget_sent(now_s)
        if self._oldest > oldest:
            del self._untold[: bisect_left(self._untold, self._oldest)]

    def _forget_sent(self, now_s: float) -> None:
        while self._oldest < self._next:
            number = self._oldest
            entry = self._sent.get(number)
            if entry is not None:
                if now_s - entry[0] <= FORGOTTEN_S and self._next - number < _MOST:
                    return
                del self._sent[number]
                self._ahead = max(self._ahead, number + 1)
            self._oldest = number + 1


def _delivery(sent: _Sent, arrived_s: float | None) -> Delivery:
    sent_s, size_bytes, kind, train = sent
    return Delivery(sent_s, arrived_s, size_bytes, kind, train)


def _signed16(number: int) -> int:
    return (number + 0x8000 & 0xFFFF) - 0x8000


def _number(told: tuple[int, _Sent, float | None]) -> int:
    return told[0]
