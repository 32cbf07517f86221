"""Collects the feedback on each packet train, which is a picture sent as a probe."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Final

from wax.congestion.dispersion import TrainDispersion

if TYPE_CHECKING:
    from wax.congestion.delivery import Delivery
    from wax.congestion.send_history import SendHistory

_MAX_TRAINS: Final = 64
"""Trains in flight at most: 2 s of pictures. Bounds the memory."""
_MAX_DISPERSION_S: Final = 30.0
"""A train with a longer dispersion is ignored as invalid."""
_MIN_TRIMMED_PACKETS: Final = 3
"""Minimum packets: without its longest gap, a shorter train has no gap left."""


class PacketTrain:
    """A train that leaves faster than the estimated rate."""

    __slots__ = ("arrivals", "expected", "lost_bytes", "reported")

    def __init__(self, packets: int) -> None:
        self.expected = packets
        self.reported = 0
        self.lost_bytes = 0
        """Lost since the last arrival: sent, but without taking time at the bottleneck."""
        self.arrivals: list[tuple[float, float, float]] = []
        """For each packet: time sent, time arrived, bits since the packet before."""

    def dispersion(self, now_s: float) -> TrainDispersion | None:
        """Return the train's dispersion, None if fewer than two packets arrived."""
        if len(self.arrivals) < 2:
            return None
        (first_sent_s, first_came_s, _), (sent_s, came_s, _) = self.arrivals[0], self.arrivals[-1]
        bits = sum(bits for _, _, bits in self.arrivals[1:])
        if bits <= 0 or not first_came_s <= came_s < first_came_s + _MAX_DISPERSION_S:
            return None
        sent_in_s = max(sent_s - first_sent_s, 1e-6)
        return TrainDispersion(now_s, bits, sent_in_s, came_s - first_came_s)

    def trimmed_bps(self) -> float | None:
        """Return the rate without the longest gap, None if fewer than three packets arrived.

        A slow link spreads a train evenly; a stall makes one gap.
        """
        if len(self.arrivals) < _MIN_TRIMMED_PACKETS:
            return None
        gaps = [(came_s - before[1], bits) for before, (_, came_s, bits) in pairwise(self.arrivals)]
        longest = max(gaps)
        took_s = sum(gap_s for gap_s, _ in gaps) - longest[0]
        bits = sum(bits for _, bits in gaps) - longest[1]
        return bits / took_s if took_s > 0 else None


class PacketTrains:
    """The trains in flight, a bounded number."""

    def __init__(self, history: SendHistory) -> None:
        self._history = history
        self._trains: dict[int, PacketTrain] = {}

    def expect(self, number: int, packets: int) -> None:
        if len(self._trains) >= _MAX_TRAINS:
            del self._trains[next(iter(self._trains))]
        self._trains[number] = PacketTrain(packets)

    def add(self, delivery: Delivery) -> list[PacketTrain]:
        """Count a packet, in the order of sending; return the trains that it completes."""
        older = [number for number in self._trains if number < (delivery.train or 0)]
        whole = [self._trains.pop(number) for number in older]
        train = None if delivery.train is None else self._trains.get(delivery.train)
        if delivery.arrived_s is None:
            for running in self._trains.values():
                running.lost_bytes += delivery.size_bytes
        elif train is not None:
            bits = 0.0
            if train.arrivals:
                since_s = train.arrivals[-1][0]
                left = self._history.between(since_s, delivery.sent_s) - train.lost_bytes
                bits = 8.0 * max(left, delivery.size_bytes)
            train.arrivals.append((delivery.sent_s, delivery.arrived_s, bits))
            train.lost_bytes = 0
        if train is not None:
            train.reported += 1
            if train.reported >= train.expected:
                whole.append(self._trains.pop(delivery.train or 0))
        return whole

    def clear(self) -> None:
        self._trains.clear()
