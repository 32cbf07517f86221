"""The tape's step, as it is read off the card."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING

import av
import pytest
from e2e.strangers.soak.tape import skews_ms
from tests.turned_clock import TurnedClock

from wax.capture.source import SAMPLE_RATE_HZ
from wax.capture.testcard import TestCardAudio, TestCardVideo
from wax.clock import SystemClock
from wax.config.settings import AudioSettings, VideoSettings

if TYPE_CHECKING:
    from pathlib import Path

WIDTH, HEIGHT, FPS, SECONDS = 320, 240, 20, 4
_MS = Fraction(1, 1000)


class Wall(TurnedClock):
    """Begins now, by people's time; whoever sleeps turns it."""

    def __init__(self) -> None:
        super().__init__(0.0)
        self._began_ms = SystemClock().wall_ms()

    def wall_ms(self) -> int:
        return self._began_ms + math.floor(self.time_s * 1000)

    def sleep(self, duration_s: float) -> None:
        self.time_s += duration_s


def record(path: Path, late_ms: int, *, silent_s: float) -> None:
    """Write the card; its sound stands `late_ms` too late, and ends `silent_s` too soon."""
    with av.open(path, "w") as file:
        video = file.add_stream("libvpx", rate=FPS, options={"deadline": "realtime"})
        video.width, video.height, video.bit_rate = WIDTH, HEIGHT, 1_000_000
        audio = file.add_stream("libopus", rate=SAMPLE_RATE_HZ, layout="mono")
        clock = Wall()
        card = TestCardVideo(
            VideoSettings(width=WIDTH, height=HEIGHT, fps=FPS), clock, sleep=clock.sleep
        )
        card.open()
        for _ in range(FPS * SECONDS):
            picture = card.read()
            frame = av.VideoFrame.from_ndarray(picture.i420, format="yuv420p")
            frame.pts, frame.time_base = round(picture.captured_s * 1000), _MS
            file.mux(video.encode(frame))
        file.mux(video.encode())
        clock.time_s = 0.0
        tone = TestCardAudio(AudioSettings(), clock, sleep=clock.sleep)
        tone.open()
        for _ in range(round((SECONDS - silent_s) * 100)):
            block = tone.read()
            sound = av.AudioFrame.from_ndarray(block.samples[None, :], format="s16", layout="mono")
            sound.sample_rate, sound.time_base = SAMPLE_RATE_HZ, Fraction(1, SAMPLE_RATE_HZ)
            sound.pts = round(block.captured_s * SAMPLE_RATE_HZ) + late_ms * SAMPLE_RATE_HZ // 1000
            file.mux(audio.encode(sound))
        file.mux(audio.encode())


@pytest.mark.parametrize("late_ms", [0, 25])
def test_sound_that_stands_too_late_is_told(late_ms: int, tmp_path: Path) -> None:
    """At every whole second, to within 2 ms."""
    record(path := tmp_path / "card.webm", late_ms, silent_s=0.0)
    skews = skews_ms(path)
    assert len(skews) >= SECONDS - 1
    assert all(skew == pytest.approx(late_ms, abs=2.0) for skew in skews)


def test_a_second_without_its_burst_is_told(tmp_path: Path) -> None:
    """What is missing is not left out of the count."""
    record(path := tmp_path / "card.webm", 0, silent_s=1.2)
    assert skews_ms(path)[-1] is None
