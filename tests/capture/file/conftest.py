"""Clips that are written for a test, and a player that reads them on a fake clock."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Any, Literal, Protocol

import av
import numpy as np
import pytest
from tests.turned_clock import TurnedClock

from wax.capture.file.media_file import FileAudio, FileVideo, MediaFile
from wax.capture.source import SAMPLE_RATE_HZ
from wax.config.audio import AudioSettings
from wax.config.video import VideoSettings
from wax.errors import SourceError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from wax.capture.source import Picture, Sound

SIZE = VideoSettings(width=160, height=120)
FLASH_S = 0.3
"""In every second of a clip a flash and a beep begin here and last 0.1 s."""

FAST = {
    "libx264": {"preset": "veryfast"},
    "libvpx": {"deadline": "realtime", "cpu-used": "8"},
}


class FakeClock(TurnedClock):
    """Advances when somebody sleeps on it."""

    def sleep(self, duration_s: float) -> None:
        self.time_s += duration_s


def write_clip(
    path: Path,
    *,
    seconds: float = 2.0,
    video: str | None = "libx264",
    audio: str | None = "aac",
    size: tuple[int, int] = (160, 120),
    audio_s: float | None = None,
    rate_hz: int = SAMPLE_RATE_HZ,
    layout: str = "mono",
    times_ms: list[int] | None = None,
    options: dict[str, str] | None = None,
) -> Path:
    """Write a clip with a flash and a beep in each second; `times_ms` for a variable rate."""
    times = times_ms or [round(index * 1000 / 30) for index in range(round(seconds * 30))]
    with av.open(str(path), "w", options=options or {}) as out:
        streams: list[av.VideoStream | av.AudioStream] = []
        if video is not None:
            picture = out.add_stream(video, rate=30)
            assert isinstance(picture, av.VideoStream)
            picture.width, picture.height, picture.pix_fmt = *size, "yuv420p"
            picture.gop_size = 15
            picture.options = {"threads": "1", **FAST.get(video, {})}
            picture.codec_context.time_base = Fraction(1, 1000)
            streams.append(picture)
        if audio is not None:
            sound = out.add_stream(audio, rate=rate_hz, layout=layout)
            assert isinstance(sound, av.AudioStream)
            streams.append(sound)
        packets = []
        for stream in streams:
            frames = (
                video_frames(times, size)
                if isinstance(stream, av.VideoStream)
                else audio_frames(audio_s or seconds, rate_hz, layout, stream.frame_size or 1024)
            )
            for frame in [*frames, None]:
                packets += stream.encode(frame)
        for packet in sorted(packets, key=lambda p: float((p.dts or 0) * p.time_base)):
            out.mux(packet)
    return path


def video_frames(times_ms: list[int], size: tuple[int, int]) -> Iterator[av.VideoFrame]:
    for time_ms in times_ms:
        frame = av.VideoFrame(*size, "yuv420p")
        flash = (time_ms / 1000 - FLASH_S + 0.001) % 1 < 0.1
        for plane, grey in zip(frame.planes, (235 if flash else 60, 128, 128), strict=True):
            plane.update(bytes([grey]) * plane.buffer_size)
        frame.pts, frame.time_base = time_ms, Fraction(1, 1000)
        yield frame


def audio_frames(seconds: float, rate_hz: int, layout: str, length: int) -> Iterator[av.AudioFrame]:
    time_s = np.arange(round(seconds * rate_hz)) / rate_hz
    beep = np.where((time_s - FLASH_S) % 1 < 0.1, 0.5 * np.sin(2 * np.pi * 1000 * time_s), 0)
    samples = np.round(beep * 32767).astype(np.int16)
    for begin in range(0, len(samples), length):
        piece = samples[begin : begin + length]
        interleaved = np.repeat(piece, 2 if layout == "stereo" else 1).reshape(1, -1)
        frame = av.AudioFrame.from_ndarray(interleaved, "s16", layout)
        frame.sample_rate, frame.pts, frame.time_base = rate_hz, begin, Fraction(1, rate_hz)
        yield frame


class Player:
    """Opens the wanted sources of a file on a fake clock and reads whichever is behind."""

    def __init__(
        self,
        address: Path | str,
        *,
        video: bool = True,
        audio: bool = True,
        channels: Literal[1, 2] = 1,
    ) -> None:
        self.clock = FakeClock(500.0)
        file = MediaFile(str(address), self.clock, sleep=self.clock.sleep)
        self.video: FileVideo | None = file.video(SIZE) if video else None
        self.audio: FileAudio | None = (
            file.audio(AudioSettings(channels=channels)) if audio else None
        )
        self.pictures: list[Picture] = []
        self.sounds: list[Sound] = []

    def __enter__(self) -> Player:
        try:
            for face in (self.video, self.audio):
                if face is not None:
                    face.open()
        except SourceError:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        for face in (self.video, self.audio):
            if face is not None:
                face.close()

    def play(self, duration_s: float) -> Player:
        end_s = self.clock.now_s() + duration_s
        while self.clock.now_s() < end_s:
            shown_s = self.pictures[-1].captured_s if self.pictures else 0.0
            heard_s = self.sounds[-1].captured_s if self.sounds else 0.0
            if self.video is not None and (self.audio is None or shown_s <= heard_s):
                self.pictures.append(self.video.read())
            elif self.audio is not None:
                self.sounds.append(self.audio.read())
        return self

    def flashes(self) -> list[float]:
        """Return when each flash began."""
        lit = [picture.i420[: picture.height].mean() > 150 for picture in self.pictures]
        return [
            picture.captured_s
            for picture, now, before in zip(self.pictures[1:], lit[1:], lit, strict=False)
            if now and not before
        ]

    def beeps(self) -> list[float]:
        """Return when each beep began."""
        samples = np.concatenate([sound.samples for sound in self.sounds])
        times = np.concatenate(
            [s.captured_s + np.arange(len(s.samples)) / SAMPLE_RATE_HZ for s in self.sounds]
        )
        loud = np.flatnonzero(np.abs(samples.astype(int)) > 3000)
        return [
            float(times[i])
            for i in loud[np.diff(loud, prepend=-SAMPLE_RATE_HZ) > SAMPLE_RATE_HZ // 5]
        ]


class MakeClip(Protocol):
    """Writes a clip under this name; the other arguments are those of `write_clip`."""

    def __call__(self, name: str, **how: Any) -> Path: ...


@pytest.fixture
def make_clip(tmp_path: Path) -> MakeClip:
    def make(name: str, **how: Any) -> Path:
        return write_clip(tmp_path / name, **how)

    return make


@pytest.fixture
def open_player() -> type[Player]:
    return Player
