"""The media that every peer sends: a camera and a microphone, as in aiortc's own examples.

The work is the same for all, and the same as WAX's largest rendition: VP8 of a size of
`e2e.peers.sizes` at 30 fps, and Opus. The tracks yield frames, so aiortc encodes them and answers
keyframe requests.
"""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Final

import aiortc.codecs.vpx
import numpy as np
from aiortc import MediaStreamTrack
from av import AudioFrame, VideoFrame

from e2e.peers.sizes import VGA
from wax.capture.source import SAMPLE_RATE_HZ
from wax.capture.testcard import TestCardAudio
from wax.clock import SystemClock
from wax.config.audio import AudioSettings

if TYPE_CHECKING:
    from collections.abc import Iterator

    from e2e.peers.sizes import Size
    from wax.capture.source import AudioSource, VideoSource

VIDEO_CLOCK_HZ: Final = 90_000


@contextmanager
def sources(size: Size = VGA) -> Iterator[tuple[VideoSource, AudioSource]]:
    """Open the test card."""
    camera = size.camera()
    microphone = TestCardAudio(AudioSettings(source="testcard", channels=1), SystemClock())
    with ExitStack() as opened:
        for source in (camera, microphone):
            source.open()
            opened.callback(source.close)
        yield camera, microphone


def set_bitrate(size: Size) -> None:
    """Let aiortc's VP8 start at what the size may have, by the usual patch: there is no public way.

    What its congestion control may grow to is no less, and else as shipped.
    """
    vpx = aiortc.codecs.vpx
    vpx.DEFAULT_BITRATE = size.bitrate_bps
    vpx.MAX_BITRATE = max(vpx.MAX_BITRATE, size.bitrate_bps)


class _Track(MediaStreamTrack):
    """Reads a source in a thread, as aiortc's `MediaPlayer` does."""

    def __init__(self, source: Any) -> None:
        super().__init__()
        self._source = source
        self._thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix=self.kind)

    async def _read(self) -> Any:
        loop = asyncio.get_running_loop()
        return await loop.run_in_executor(self._thread, self._source.read)


class CameraTrack(_Track):
    kind = "video"

    async def recv(self) -> VideoFrame:
        picture = await self._read()
        frame = VideoFrame.from_ndarray(picture.i420, format="yuv420p")
        frame.pts = round(picture.captured_s * VIDEO_CLOCK_HZ)
        frame.time_base = Fraction(1, VIDEO_CLOCK_HZ)
        return frame


class MicrophoneTrack(_Track):
    """Returns two of the card's blocks at once: Opus takes 20 ms."""

    kind = "audio"
    _position = 0

    async def recv(self) -> AudioFrame:
        piece = np.concatenate([(await self._read()).samples for _ in range(2)])
        frame = AudioFrame.from_ndarray(piece.reshape(1, -1), format="s16", layout="mono")
        frame.sample_rate = SAMPLE_RATE_HZ
        frame.pts = self._position
        frame.time_base = Fraction(1, SAMPLE_RATE_HZ)
        self._position += len(piece)
        return frame
