"""The bottleneck: a drop-tail queue before a transmitter."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from tests.link.schedule import Schedule


class Transmitter(Protocol):
    """Sends one packet after the other, and is told of each in order."""

    def start(self, now_s: float) -> None:
        """Start from its beginning whatever it does over time."""
        ...

    def finish_s(self, begin_s: float, size_bytes: int) -> float:
        """Return when the last byte of a packet leaves whose turn comes at `begin_s`."""
        ...


class RateTransmitter:
    """Sends at the rate of a schedule, exact to the bit, even across its changes and outages."""

    def __init__(self, schedule: Schedule) -> None:
        self._schedule = schedule

    def start(self, now_s: float) -> None:
        """Do nothing: it follows the schedule, which its owner starts."""

    def finish_s(self, begin_s: float, size_bytes: int) -> float:
        bits = size_bytes * 8.0
        while True:
            conditions = self._schedule.at(begin_s)
            change_s = self._schedule.change_after_s(begin_s)
            if not conditions.outage:
                if conditions.rate_bps is None:
                    return begin_s
                done_s = begin_s + bits / conditions.rate_bps
                if done_s <= change_s:
                    return done_s
                bits -= (change_s - begin_s) * conditions.rate_bps
            begin_s = change_s


class Backlog:
    """The bytes that have not left yet, including the packet on the wire."""

    def __init__(self) -> None:
        self._waiting: deque[tuple[float, int]] = deque()
        self._bytes = 0
        self.free_s = 0.0
        """When the last packet has left."""

    def bytes_at(self, now_s: float) -> int:
        """Return the count; `now_s` never falls."""
        while self._waiting and self._waiting[0][0] <= now_s:
            self._bytes -= self._waiting.popleft()[1]
        return self._bytes

    def has_room(self, size_bytes: int, limit_bytes: float, now_s: float) -> bool:
        """Return whether a packet fits (drop-tail): within the limit, or into an empty queue."""
        waiting_bytes = self.bytes_at(now_s)
        return waiting_bytes == 0 or waiting_bytes + size_bytes <= limit_bytes

    def add(self, size_bytes: int, leaves_s: float) -> None:
        self._waiting.append((leaves_s, size_bytes))
        self._bytes += size_bytes
        self.free_s = leaves_s
