"""Trials of hardware encoders, in a separate process, because a driver may hang or crash.

All renditions are encoded at once, as in the server, decoded again and compared. The process reads
the candidates as JSON, and writes a line of JSON for each encoder after its trial.
"""

from __future__ import annotations

import json
import statistics
import sys
import time
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any, Final

import av
import numpy as np
from av.error import FFmpegError
from av.packet import Packet
from av.video.codeccontext import VideoCodecContext

from wax.capture.letterbox import planes
from wax.capture.source import Picture
from wax.config.video import RenditionSettings
from wax.encode.hardware import Hardware, HardwareEncoder, HardwareError
from wax.encode.parameter_sets import can_start_decoder, profile
from wax.errors import reason_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

PICTURES: Final = 30
_KEYFRAMES: Final = frozenset({0, 20})
_BASELINE: Final = 66
_ALIKE: Final = 0.8
_SETTLED: Final = 10
"""Once the rate has settled, any encoder, even at 16 kbit/s, exceeds `_ALIKE`."""
_LATEST_PICTURES: Final = 3
"""How many may take longer than a picture lasts: the first ones, or on a busy machine."""


@dataclass(frozen=True, slots=True)
class Trial:
    """The result of a trial: for each working rendition the milliseconds that a picture takes.

    `refused` gives the reason for each other rendition; `problem` is set if none works.
    """

    encoder: str
    ms: dict[str, float] = field(default_factory=dict)
    refused: dict[str, str] = field(default_factory=dict)
    problem: str | None = None


class _Subject:
    """One rendition on trial; `refused` is the reason for its failure, None until then."""

    def __init__(self, hardware: Hardware, rendition: RenditionSettings) -> None:
        self.rendition = rendition
        self.refused: str | None = None
        self.took_s: list[float] = []
        self._encoder: HardwareEncoder | None = None
        decoder = av.CodecContext.create("h264", "r")
        assert isinstance(decoder, VideoCodecContext)
        decoder.thread_count = 1
        self._decoder = decoder
        try:
            self._encoder = HardwareEncoder(hardware, rendition)
        except HardwareError as error:
            self.refused = str(error)

    def check(self, number: int, i420: NDArray[np.uint8]) -> None:
        """Encode the picture of this number, and check the decoded result."""
        if self._encoder is None or self.refused is not None:
            return
        try:
            self._encode_and_compare(self._encoder, number, i420)
        except HardwareError as error:
            self.refused = str(error)
        except FFmpegError as error:
            self.refused = f"what it gives cannot be decoded ({reason_of(error)})"

    def judge(self) -> None:
        """Refuse the rendition if it is too slow."""
        if self.refused is not None:
            return
        late = sum(one > 1 / self.rendition.fps for one in self.took_s)
        if late > _LATEST_PICTURES:
            self.refused = f"it is too slow: {self.ms:.0f} ms a picture"

    @property
    def ms(self) -> float:
        return statistics.median(self.took_s) * 1000 if self.took_s else 0.0

    def _encode_and_compare(
        self, encoder: HardwareEncoder, number: int, i420: NDArray[np.uint8]
    ) -> None:
        wanted = number in _KEYFRAMES
        began_s = time.perf_counter()
        encoded = encoder.encode(Picture(i420, 1000 + number / self.rendition.fps), keyframe=wanted)
        self.took_s.append(time.perf_counter() - began_s)
        assert encoded is not None, "each picture is newer than the one before"
        if wanted and not (encoded.keyframe and can_start_decoder(encoded.data)):
            raise HardwareError("nobody could begin at a keyframe that was requested")
        if wanted and profile(encoded.data) != _BASELINE:
            raise HardwareError(f"it makes profile {profile(encoded.data)} instead of baseline")
        frames = self._decoder.decode(Packet(encoded.data))
        if len(frames) != 1:
            raise HardwareError(f"a picture is {len(frames)} when it is decoded")
        if (frames[0].width, frames[0].height) != (self.rendition.width, self.rendition.height):
            raise HardwareError(f"its pictures have {frames[0].width}×{frames[0].height}")
        seen = np.asarray(frames[0].to_ndarray(format="yuv420p"), np.uint8)
        if number >= _SETTLED and likeness(i420, seen) < _ALIKE:
            raise HardwareError("its pictures do not look like what they show")


def run(hardware: Hardware, renditions: Sequence[RenditionSettings]) -> Trial:
    """Try the encoder with all renditions at once, in this process."""
    subjects = [_Subject(hardware, one) for one in renditions]
    for number in range(PICTURES):
        pictures: dict[tuple[int, int], NDArray[np.uint8]] = {}
        for subject in (one for one in subjects if one.refused is None):
            size = (subject.rendition.width, subject.rendition.height)
            if size not in pictures:
                pictures[size] = waves(*size, number)
            subject.check(number, pictures[size])
    for subject in subjects:
        subject.judge()
    refused = {one.rendition.name: one.refused for one in subjects if one.refused is not None}
    return Trial(
        encoder=hardware.name,
        ms={one.rendition.name: round(one.ms, 2) for one in subjects if one.refused is None},
        refused=refused,
        problem=next(iter(refused.values())) if len(refused) == len(subjects) else None,
    )


def waves(width: int, height: int, number: int) -> NDArray[np.uint8]:
    """Return soft, moving waves of full contrast, which every encoder preserves at any rate."""
    across = np.arange(width) / width + number / 300
    down = np.arange(height)[:, None] / height
    i420 = np.empty((height * 3 // 2, width), np.uint8)
    luma, blue, red = planes(i420)
    luma[:] = np.round(126 + 90 * np.sin(2 * np.pi * across) * np.cos(2 * np.pi * down))
    blue[:] = np.round(128 + 60 * np.sin(2 * np.pi * across[::2]))
    red[:] = np.round(128 + 60 * np.cos(2 * np.pi * down[::2]))
    return i420


def likeness(shown: NDArray[np.uint8], seen: NDArray[np.uint8]) -> float:
    """Return the lowest correlation of the three planes: 1 is alike, 0 grey, green or noise."""
    return min(
        _correlation(one, other) for one, other in zip(planes(shown), planes(seen), strict=True)
    )


def _correlation(one: NDArray[Any], other: NDArray[Any]) -> float:
    first, second = one - one.mean(), other - other.mean()
    scale = float(np.sqrt((first**2).sum() * (second**2).sum()))
    return float((first * second).sum()) / scale if scale else 0.0


def main() -> None:
    av.logging.set_level(av.logging.ERROR)  # an encoder's errors are the reason for its failure
    av.logging.set_skip_repeated(False)
    asked = json.load(sys.stdin)
    renditions = [RenditionSettings.model_validate(one) for one in asked["renditions"]]
    for candidate in asked["candidates"]:
        trial = run(Hardware(**candidate), renditions)
        print(json.dumps(asdict(trial)), flush=True)  # noqa: T201  # to the process that asked


if __name__ == "__main__":
    main()
