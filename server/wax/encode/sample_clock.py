"""The media time of the sound, which counts samples and jumps only at gaps in the sound."""

from __future__ import annotations

from typing import Final

from wax.capture.source import BLOCK_MS, BLOCK_SAMPLES

_GAP_S: Final = 0.05
"""A block this much later than the end of the previous one follows a gap."""

_BLOCKS_PER_S: Final = 1000 // BLOCK_MS


class SampleClock:
    """Gives every block its `pts` in samples, always a whole multiple of a block.

    An RTP time that is off by one sample makes a browser conceal, so samples are counted. Drift of
    the sound card does no harm, because the capture time, which `capture/audio_blocks.py` smooths,
    is sent separately. After a gap counting continues at the capture time. The time always rises.
    """

    def __init__(self) -> None:
        self._due_s: float | None = None
        self.next_pts = 0

    def stamp(self, captured_s: float) -> int:
        """Return the media time of the next block, captured at `captured_s`."""
        if self._due_s is None or captured_s - self._due_s > _GAP_S:
            self.next_pts = max(self.next_pts, round(captured_s * _BLOCKS_PER_S) * BLOCK_SAMPLES)
        self._due_s = captured_s + 1 / _BLOCKS_PER_S
        pts = self.next_pts
        self.next_pts += BLOCK_SAMPLES
        return pts
