"""Sent packets for retransmission, as many as a browser may still request. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.rtc.rtp import Packet

_MOST: Final = 1024
"""Chromium requests packets up to about this far back (its NACK module: 1000)."""
_KEPT_S: Final = 2.0
"""Older packets are useless: congestion control refuses them after 0.5 s and a round trip. A good
rendition sends 150 packets/s, so time bounds the memory, and the number only a burst."""


class RetransmissionBuffer:
    """The newest packets of one stream, by their sequence numbers."""

    def __init__(self) -> None:
        self._sent: dict[int, tuple[Packet, float]] = {}

    def add(self, packets: Sequence[Packet], now_s: float) -> None:
        """Keep packets with consecutive sequence numbers that leave now."""
        for packet in packets:
            self._sent[packet.sequence_number] = packet, now_s
        while len(self._sent) > len(packets):
            oldest = next(iter(self._sent))
            if len(self._sent) <= _MOST and self._sent[oldest][1] >= now_s - _KEPT_S:
                break
            del self._sent[oldest]

    def __contains__(self, sequence_number: int) -> bool:
        return sequence_number in self._sent

    def get(self, sequence_number: int) -> tuple[Packet, float] | None:
        """Return a packet and when it left, None if it is too old or was never sent."""
        return self._sent.get(sequence_number)
