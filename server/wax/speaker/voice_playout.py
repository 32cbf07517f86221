"""Turns a voice's packets into the sound that is due: reorder, decode, conceal, limit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.errors import ProtocolError
from wax.speaker.opus_decoder import OpusDecoder
from wax.voice.concealment import Concealer
from wax.voice.jitter_buffer import JitterBuffer, Missing
from wax.voice.limiter import Limiter, SilenceGate
from wax.voice.packet import RATE_HZ

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from wax.voice.packet import VoicePacket

_LONGEST_GAP: Final = RATE_HZ * 60 // 1000
"""A longer gap is a pause, in which browsers send nothing."""


class VoicePlayout:
    """Plays out one voice at a time; takes `now_s`, has no thread and never blocks.

    It counts since the start: `lost_samples` were missing between played packets, `refused` packets
    could not be decoded.
    """

    def __init__(self) -> None:
        self._buffer = JitterBuffer()
        self._source: int | None = None
        self._decoder = OpusDecoder()
        self._concealer = Concealer()
        self._limiter = Limiter()
        self._gate = SilenceGate()
        self._expected: int | None = None
        self.lost_samples = 0
        self.refused = 0

    @property
    def is_idle(self) -> bool:
        """Whether there is nothing to play until the next packet arrives."""
        return self._buffer.is_idle

    def push(self, packet: VoicePacket, now_s: float) -> None:
        """Add a packet that arrives now; one from another source ends the previous voice."""
        if packet.source != self._source:
            self.hush()
            self._source = packet.source
        self._buffer.push(packet, now_s)

    def hush(self) -> None:
        """Discard every packet that has arrived."""
        self._buffer.clear()
        self._source = None
        self._decoder = OpusDecoder()
        self._concealer.reset()
        self._gate = SilenceGate()
        self._expected = None

    def pop_due(self, now_s: float) -> list[NDArray[np.int16]]:
        """Remove and return the due pieces that are not silent, int16 mono at 48 kHz."""
        pieces = []
        while (item := self._buffer.pop_due(now_s)) is not None:
            piece = self._limiter.limit(self._sound_of(item))
            if self._gate.opens(piece) and len(piece):
                pieces.append(piece)
        return pieces

    def _sound_of(self, item: VoicePacket | Missing) -> NDArray[np.int16]:
        if isinstance(item, Missing):
            return self._concealer.conceal(item.samples)
        self._count_missing(item)
        try:
            return self._concealer.join(self._decoder.decode(item))
        except ProtocolError:
            self.refused += 1
            return self._concealer.conceal(item.samples)

    def _count_missing(self, packet: VoicePacket) -> None:
        """Count the samples lost before this packet, unless the gap is a pause."""
        if self._expected is not None:
            gap = (packet.timestamp - self._expected) % 2**32
            self.lost_samples += gap if gap <= _LONGEST_GAP else 0
        self._expected = packet.timestamp + packet.samples
