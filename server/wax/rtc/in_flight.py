"""The packets in flight to one viewer: sent, but without feedback yet. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal

from wax.congestion.delivery import Delivery
from wax.rtc.feedback import PERIOD_S

if TYPE_CHECKING:
    from wax.rtc.feedback import Feedback

FORGOTTEN_S: Final = 5.0
"""A packet without feedback for this long is forgotten."""

_MOST: Final = 2**15
"""Half of the 16-bit numbers: with more in flight they would be ambiguous."""

_Kind = Literal["audio", "video", "repeat"]


class InFlight:
    """Numbers packets for transport-wide feedback and matches the feedback with them.

    Internally, numbers and the browser's clock are unwrapped. Memory is bounded by what is sent in
    5 s; the cost of a call is proportional to what it reports or forgets.
    """

    def __init__(self) -> None:
        self._sent: dict[int, tuple[float, int, _Kind, int | None]] = {}
        self._oldest = 0
        self._next = 0
        self._ahead = 0  # the first number after all that have arrived
        self._missing: set[int] = set()
        self._told_lost: set[int] = set()
        self._newest_arrived_s: float | None = None

    def sent(self, now_s: float, *, size_bytes: int, kind: _Kind, train: int | None) -> int:
        """Record a packet that leaves now; returns its transport-wide number, 16 bits."""
        self._forget(now_s)
        number = self._next
        self._sent[number] = (now_s, size_bytes, kind, train)
        self._next = number + 1
        return number & 0xFFFF

    def reported(self, feedback: Feedback, now_s: float) -> tuple[Delivery, ...]:
        """Return what is new in this feedback, in the order of sending.

        An arrival is reported once. A loss is reported when a later packet has arrived, and may be
        followed by an arrival, because packets overtake each other. `arrived_s` never wraps, though
        the browser's clock does.
        """
        self._forget(now_s)
        arrivals = feedback.arrivals
        start = self._next + _signed16(feedback.sequence_number - self._next)
        known = range(max(start, self._oldest), min(start + len(arrivals), self._next))
        told: list[tuple[int, float | None]] = []
        shift_s: float | None = None
        for number in known:
            if number not in self._sent:
                continue
            arrived_s = arrivals[number - start]
            if arrived_s is not None:
                if shift_s is None:
                    shift_s = self._shift_s(arrived_s)
                told.append((number, arrived_s + shift_s))
                self._missing.discard(number)
            elif number not in self._told_lost:
                self._missing.add(number)
        if told:
            newest, self._newest_arrived_s = told[-1]
            self._pass(newest)
        if self._missing:
            lost = [number for number in self._missing if number < self._ahead]
            self._missing.difference_update(lost)
            self._told_lost.update(lost)
            told += [(number, None) for number in lost]
            told.sort(key=_number)
        return tuple([self._delivery(number, arrived_s) for number, arrived_s in told])

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

    def _pass(self, arrived: int) -> None:
        """Remove all up to this number: they arrived, are lost, or had no feedback."""
        self._ahead = max(self._ahead, arrived + 1)

    def _delivery(self, number: int, arrived_s: float | None) -> Delivery:
        if arrived_s is None:
            sent_s, size_bytes, kind, train = self._sent[number]
        else:
            sent_s, size_bytes, kind, train = self._sent.pop(number)
            self._told_lost.discard(number)
        return Delivery(sent_s, arrived_s, size_bytes, kind, train)

    def _forget(self, now_s: float) -> None:
        while self._oldest < self._next:
            number = self._oldest
            entry = self._sent.get(number)
            if entry is not None:
                if now_s - entry[0] <= FORGOTTEN_S and self._next - number < _MOST:
                    return
                del self._sent[number]
                self._missing.discard(number)
                self._told_lost.discard(number)
                self._ahead = max(self._ahead, number + 1)
            self._oldest = number + 1


def _signed16(number: int) -> int:
    return (number + 0x8000 & 0xFFFF) - 0x8000


def _number(told: tuple[int, float | None]) -> int:
    return told[0]
