"""Puts together what was told of each picture's packets."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.congestion.dispersion import TrainDispersion

if TYPE_CHECKING:
    from wax.congestion.delivery import Delivery
    from wax.congestion.send_history import SendHistory

_MOST: Final = 64
_LONGEST_S: Final = 30.0
_LEAST_TRIMMED: Final = 3


class PacketTrain:
    """A train that leaves faster than the link is known to be."""

    __slots__ = ("arrivals", "told", "toll_bytes", "wanted")

    def __init__(self, packets: int) -> None:
        self.wanted = packets
        self.told = 0
        self.toll_bytes = 0
        """What was lost since the last packet that came: it left, but took no time at the link."""
        self.arrivals: list[tuple[float, float, float]] = []
        """When each was sent, when it came, and the bits since the one before."""

    def passage(self, now_s: float) -> TrainDispersion | None:
        """Return how the train went through, None where fewer than two packets came."""
        if len(self.arrivals) < 2:
            return None
        (first_sent_s, first_came_s, _), (sent_s, came_s, _) = self.arrivals[0], self.arrivals[-1]
        bits = sum(bits for _, _, bits in self.arrivals[1:])
        if bits <= 0 or not first_came_s <= came_s < first_came_s + _LONGEST_S:
            return None
        return TrainDispersion(now_s, bits, max(sent_s - first_sent_s, 1e-6), came_s - first_came_s)

    def trimmed_bps(self) -> float | None:
        """Return the rate without the longest pause, None where fewer than three packets came.

        A slow link spreads a train evenly; a stall makes one pause.
        """
        if len(self.arrivals) < _LEAST_TRIMMED:
            return None
        gaps = [
            (came_s - before[1], bits)
            for before, (_, came_s, bits) in zip(self.arrivals, self.arrivals[1:], strict=False)
        ]
        longest = max(gaps)
        took_s = sum(gap_s for gap_s, _ in gaps) - longest[0]
        bits = sum(bits for _, bits in gaps) - longest[1]
        return bits / took_s if took_s > 0 else None


class PacketTrains:
    """The probes that are on their way, a bounded number."""

    def __init__(self, log: SendHistory) -> None:
        self._log = log
        self._probes: dict[int, PacketTrain] = {}
        self._lost_bytes = 0

    def expect(self, number: int, packets: int) -> None:
        if len(self._probes) >= _MOST:
            del self._probes[next(iter(self._probes))]
        self._probes[number] = PacketTrain(packets)

    def add(self, delivery: Delivery) -> list[PacketTrain]:
        """Count a packet, in the order of sending; return the probes that are whole with it."""
        older = [number for number in self._probes if number < (delivery.train or 0)]
        whole = [self._probes.pop(number) for number in older]
        probe = None if delivery.train is None else self._probes.get(delivery.train)
        if delivery.arrived_s is None:
            for running in self._probes.values():
                running.toll_bytes += delivery.size_bytes
        elif probe is not None:
            bits = 0.0
            if probe.arrivals:
                since_s = probe.arrivals[-1][0]
                left = self._log.between(since_s, delivery.sent_s) - probe.toll_bytes
                bits = 8.0 * max(left, delivery.size_bytes)
            probe.arrivals.append((delivery.sent_s, delivery.arrived_s, bits))
            probe.toll_bytes = 0
        if probe is not None:
            probe.told += 1
            if probe.told >= probe.wanted:
                whole.append(self._probes.pop(delivery.train or 0))
        return whole

    def clear(self) -> None:
        self._probes.clear()
