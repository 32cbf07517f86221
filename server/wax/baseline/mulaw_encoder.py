"""Sound as it was in 2004: µ-law, 8 kHz, in media units of up to half a second (thesis 3.4.1)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import av
import numpy as np

from wax.capture.source import BLOCK_MS, BLOCK_SAMPLES, SAMPLE_RATE_HZ, Sound
from wax.encode.encoded import EncodedSound, SoundUnit

if TYPE_CHECKING:
    from numpy.typing import NDArray

MULAW_RATE_HZ: Final = 8000
_PACKET_MS: Final = (100, 80, 60, 40, 20)
"""100 ms (800 bytes), or the longest that divides the unit, about a TCP segment of 2004. Packets of
the usual 20 ms (RFC 3551, 4.2) are a quarter headers, which would overload a modem line."""

_RESEAM_S: Final = 0.05
_FILTER_SAMPLES: Final = 96
"""The look-ahead of the resampler's low-pass filter, at 48 kHz. The same amount of silence precedes
the sound, so that a unit is complete with its last sample; its capture time allows for the 2 ms."""


class MuLawEncoder:
    """Encodes 48 kHz mono sound as bursts of PCMU packets, `mu_ms` (a multiple of 20) a unit.

    RTP time counts samples, and every unit begins at a whole multiple of its length: the next one
    after the source has jumped by more than 50 ms.
    """

    def __init__(self, *, mu_ms: int) -> None:
        self.unit_samples = MULAW_RATE_HZ * mu_ms // 1000
        self._blocks_per_unit = mu_ms // BLOCK_MS
        packet_ms = next(ms for ms in _PACKET_MS if mu_ms % ms == 0)
        self._packet_samples = MULAW_RATE_HZ * packet_ms // 1000
        self._codec = av.CodecContext.create("pcm_mulaw", "w")
        assert isinstance(self._codec, av.AudioCodecContext)
        self._codec.sample_rate = MULAW_RATE_HZ
        self._codec.layout = "mono"
        self._codec.format = "s16"
        self._samples: list[NDArray[np.int16]] = []
        self._captured_s = 0.0
        self._number = 0
        self._next_pts: int | None = None
        self._due_s = 0.0
        self._begin_source()

    def encode(self, block: Sound) -> SoundUnit | None:
        """Encode one block; return a unit when it is complete, else None."""
        assert len(block.samples) == BLOCK_SAMPLES
        if self._next_pts is None or abs(block.captured_s - self._due_s) > _RESEAM_S:
            self._begin_source()
            self._next_pts = self._aligned(block.captured_s)
        self._due_s = block.captured_s + BLOCK_SAMPLES / SAMPLE_RATE_HZ
        if not self._samples:
            self._captured_s = block.captured_s - _FILTER_SAMPLES / SAMPLE_RATE_HZ
        self._samples.append(self._resample(block.samples))
        if len(self._samples) < self._blocks_per_unit:
            return None
        samples = np.concatenate(self._samples)
        self._samples.clear()
        begins = range(0, self.unit_samples, self._packet_samples)
        packets = tuple(self._packet(samples, begin, self._next_pts) for begin in begins)
        self._next_pts += self.unit_samples
        self._number += 1
        return SoundUnit(self._number, packets, self._captured_s)

    def _begin_source(self) -> None:
        """Start a new unit and discard the incomplete one."""
        self._samples.clear()
        self._resampler = av.AudioResampler(format="s16", layout="mono", rate=MULAW_RATE_HZ)
        self._resample(np.zeros(_FILTER_SAMPLES, np.int16))

    def _aligned(self, captured_s: float) -> int:
        """Return the first multiple of a unit's length that is not earlier or already used."""
        captured = max(round(captured_s * MULAW_RATE_HZ), self._next_pts or 0)
        return -(-captured // self.unit_samples) * self.unit_samples

    def _packet(self, unit: NDArray[np.int16], begin: int, unit_pts: int) -> EncodedSound:
        samples = unit[begin : begin + self._packet_samples]
        frame = av.AudioFrame.from_ndarray(samples.reshape(1, -1), format="s16", layout="mono")
        frame.sample_rate = MULAW_RATE_HZ
        return EncodedSound(
            data=b"".join(bytes(part) for part in self._codec.encode(frame)),
            pts=unit_pts + begin,
            captured_s=self._captured_s + begin / MULAW_RATE_HZ,
            duration_samples=len(samples),
        )

    def _resample(self, samples: NDArray[np.int16]) -> NDArray[np.int16]:
        frame = av.AudioFrame.from_ndarray(samples.reshape(1, -1), format="s16", layout="mono")
        frame.sample_rate = SAMPLE_RATE_HZ
        parts = [part.to_ndarray().reshape(-1) for part in self._resampler.resample(frame)]
        return np.concatenate([np.zeros(0, np.int16), *parts])
