"""Sent packets for retransmission, as many as a browser may still request. Pure."""

from __future__ import annotations

from collections import OrderedDict
from typing import Final, NamedTuple

_MOST: Final = 1024
"""Chromium requests packets up to about this far back (its NACK module: 1000)."""
_KEPT_S: Final = 2.0
"""Older packets are of no use to anybody: congestion control refuses them after 0.5 s and a round
trip. A good rendition sends 150 packets/s, so time bounds the memory, and the number only a burst.
"""


class SentPacket(NamedTuple):
    """One packet as first sent; `timestamp` is its RTP time."""

    timestamp: int
    marker: bool
    payload: bytes
    sent_s: float


class SentHistory:
    """The newest packets of one stream by sequence number."""

    def __init__(self) -> None:
        self._sent: OrderedDict[int, SentPacket] = OrderedDict()

    def add(self, sequence_number: int, packet: SentPacket) -> None:
        self._sent[sequence_number] = packet
        while len(self._sent) > _MOST or self._oldest_s() < packet.sent_s - _KEPT_S:
            self._sent.popitem(last=False)

    def get(self, sequence_number: int) -> SentPacket | None:
        """Return a packet, None if it is too old or was never sent."""
        return self._sent.get(sequence_number)

    def _oldest_s(self) -> float:
        return next(iter(self._sent.values())).sent_s
