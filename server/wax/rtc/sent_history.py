"""Sent packets for retransmission, as many as a browser may still request. Pure."""

from __future__ import annotations

from collections import OrderedDict
from typing import Final, NamedTuple

_KEPT: Final = 1024
"""Chromium requests packets up to about this far back (its NACK module: 1000)."""


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
        if len(self._sent) > _KEPT:
            self._sent.popitem(last=False)

    def get(self, sequence_number: int) -> SentPacket | None:
        """Return a packet, None if it is too old or was never sent."""
        return self._sent.get(sequence_number)
