"""A bottleneck that several flows share: one drop-tail queue, first in first out."""

from __future__ import annotations

import math
from collections import deque
from typing import TYPE_CHECKING, Protocol

from tests.link.model import Direction

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tests.link.profile import Profile

_SEGMENT_BYTES = 1448
_HEADERS_BYTES = 52
_CUBIC_C = 0.4
_CUBIC_BETA = 0.7
_MIN_RTO_S = 0.2
_REORDERED = 3
_INITIAL_SEGMENTS = 10


class Flow(Protocol):
    """A flow that shares a bottleneck."""

    now_s: float

    def next_s(self) -> float: ...

    def step(self) -> None: ...


def run(flows: Sequence[Flow], until_s: float) -> None:
    """Run all flows, in the order of their events."""
    while True:
        first = min(flows, key=lambda flow: flow.next_s())
        if first.next_s() > until_s:
            break
        first.step()
    for flow in flows:
        flow.now_s = until_s


class Port:
    """One flow's port of the bottleneck: its packets enter and leave here."""

    def __init__(self, shared: Direction) -> None:
        self._shared = shared
        self._inside: deque[tuple[float, bytes]] = deque()

    def arrive(self, packet: bytes, now_s: float) -> None:
        # A packet's fate is decided on arrival, so this is the only one inside.
        self._shared.arrive(packet, now_s)
        self._inside.extend(self._shared.due(math.inf))

    def next_s(self) -> float:
        return self._inside[0][0] if self._inside else math.inf

    def due(self, now_s: float) -> list[tuple[float, bytes]]:
        out = []
        while self._inside and self._inside[0][0] <= now_s:
            out.append(self._inside.popleft())
        return out


def bottleneck(network: Profile, *, seed: int, start_s: float) -> Direction:
    """Return a network's downlink for ports."""
    shared = Direction(network.down, seed=seed, way="down", start_s=start_s)
    shared.start_changes(start_s)
    return shared


class TcpDownload:
    """An endless download: CUBIC (RFC 9438) with selective acknowledgements, from `begin_s` on.

    Acknowledgements come back after `back_s`, one per segment, and are never lost.
    """

    def __init__(
        self, port: Port, *, back_s: float, begin_s: float, end_s: float = math.inf
    ) -> None:
        self.now_s = begin_s
        self.came_bytes: list[tuple[float, int]] = []
        self._port = port
        self._back_s = back_s
        self._end_s = end_s
        self._window = float(_INITIAL_SEGMENTS)
        self._threshold = math.inf
        self._max_window = 0.0
        self._epoch_s: float | None = None
        self._recover = 0
        self._number = 0
        self._flying: dict[int, float] = {}
        self._acks: deque[tuple[float, int]] = deque()
        self._round_trip_s = 0.2

    def next_s(self) -> float:
        if self._room() and self.now_s < self._end_s:
            return self.now_s
        ack_s = self._acks[0][0] if self._acks else math.inf
        return min(self._port.next_s(), ack_s, self._timeout_s())

    def step(self) -> None:
        if self._room() and self.now_s < self._end_s:
            self._send()
            return
        self.now_s = max(self.now_s, self.next_s())
        for due_s, data in self._port.due(self.now_s):
            self.came_bytes.append((due_s, len(data)))
            self._acks.append((due_s + self._back_s, int.from_bytes(data[:8], "big")))
        while self._acks and self._acks[0][0] <= self.now_s:
            self._acked(self._acks.popleft()[1])
        if self._flying and self._timeout_s() <= self.now_s:
            self._flying.clear()
            self._shrink()
            self._window = 1.0

    def rate_bps(self, from_s: float, until_s: float) -> float:
        came = sum(size for at_s, size in self.came_bytes if from_s <= at_s < until_s)
        return 8 * came / (until_s - from_s)

    def _room(self) -> bool:
        return len(self._flying) < int(self._window)

    def _timeout_s(self) -> float:
        if not self._flying:
            return math.inf
        oldest_s = next(iter(self._flying.values()))
        return oldest_s + max(_MIN_RTO_S, 2 * self._round_trip_s)

    def _send(self) -> None:
        self._number += 1
        self._flying[self._number] = self.now_s
        size = _SEGMENT_BYTES + _HEADERS_BYTES
        self._port.arrive(self._number.to_bytes(8, "big").ljust(size, b"\0"), self.now_s)

    def _acked(self, number: int) -> None:
        sent_s = self._flying.pop(number, None)
        if sent_s is None:
            return
        self._round_trip_s += (self.now_s - sent_s - self._round_trip_s) / 8
        lost = [other for other in self._flying if other < number - _REORDERED]
        for other in lost:
            del self._flying[other]
        if lost and lost[-1] > self._recover:
            self._shrink()
        elif self._window < self._threshold:
            self._window += 1
        else:
            self._grow()

    def _shrink(self) -> None:
        self._recover = self._number
        self._max_window = self._window
        self._window = max(_CUBIC_BETA * self._window, 2.0)
        self._threshold = self._window
        self._epoch_s = None

    def _grow(self) -> None:
        if self._epoch_s is None:
            self._epoch_s = self.now_s
        k_s = math.cbrt(self._max_window * (1 - _CUBIC_BETA) / _CUBIC_C)
        at_s = self.now_s - self._epoch_s + self._round_trip_s
        target = _CUBIC_C * (at_s - k_s) ** 3 + self._max_window
        # At least as much as Reno would send (RFC 9438, 4.3).
        reno = 3 * (1 - _CUBIC_BETA) / (1 + _CUBIC_BETA) / self._window
        self._window += max((min(target, 1.5 * self._window) - self._window) / self._window, reno)
