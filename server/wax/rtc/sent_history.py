"""Sent packets for retransmission, as many as a browser may still request. Pure."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.rtc.rtp import Packet

_MOST: Final = 1024
"""Chromium requests packets up to about this far back (its NACK module: 1000)."""
_KEPT_S: Final = 2.0
"""Older packets are of no use to anybody: congestion control refuses them after 0.5 s and a round
trip. A good rendition sends 150 packets/s, so time bounds the memory, and the number only a burst.
"""
_UINT16: Final = 2**16


class SentHistory:
    """The newest packets of one stream, by what left together, which most often is a picture."""

    def __init__(self) -> None:
        self._sent: deque[tuple[float, Sequence[Packet]]] = deque()
        self._packets = 0

    def add(self, packets: Sequence[Packet], now_s: float) -> None:
        """Keep packets with consecutive sequence numbers that leave now."""
        if packets:
            self._sent.append((now_s, packets))
            self._packets += len(packets)
        while len(self._sent) > 1 and (self._packets > _MOST or self._sent[0][0] < now_s - _KEPT_S):
            self._packets -= len(self._sent.popleft()[1])

    def get(self, sequence_number: int) -> tuple[Packet, float] | None:
        """Return a packet and when it left, None if it is too old or was never sent."""
        for sent_s, packets in reversed(self._sent):
            place = (sequence_number - packets[0].sequence_number) % _UINT16
            if place < len(packets):
                return packets[place], sent_s
        return None
