"""The tape as another viewer of the fan-out."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import numpy as np
import pytest
from tests.turned_clock import TurnedClock
from tests.until import async_until

from wax.capture.source import Sound
from wax.config.settings import Settings
from wax.fanout.sound_hub import SoundHub
from wax.fanout.video_hub import VideoHub
from wax.tape.event_ending import ending_of
from wax.tape.shelf import EVENTS, Shelf
from wax.tape.tape import TapeFeed
from wax.telemetry import Counters

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path


class Rig:
    """A tape with a fan-out that has no other viewer."""

    def __init__(self, folder: Path, **recording: object) -> None:
        known = {"enabled": True, "folder": str(folder), "min_free_gb": 0.0} | recording
        settings = Settings.model_validate({"recording": known})
        clock = TurnedClock()
        self.best = settings.video.renditions[0].name
        self.counters = Counters()
        self.video = VideoHub(settings=settings.video, clock=clock)
        self.audio = SoundHub(clock)
        self.tape = TapeFeed(
            settings, clock=clock, counters=self.counters, video=self.video, audio=self.audio
        )


@pytest.fixture
async def rig(tmp_path: Path) -> AsyncIterator[Rig]:
    made = Rig(tmp_path / "tape")
    made.video.start()
    made.audio.start()
    made.tape.start()
    yield made
    made.tape.stop()
    made.video.stop()


async def test_it_wants_the_best_picture_and_one_encoding_of_the_sound(rig: Rig) -> None:
    """The tape subscribes like a viewer on a good link; its only cost is that encoding."""
    assert rig.video.wanted == [rig.best]
    assert len(rig.audio.wanted) == 1


async def test_the_sound_is_recorded_with_the_channels_it_has(rig: Rig) -> None:
    """Sound is recorded in stereo while the microphone has two channels, else in mono."""
    lane = rig.tape._sound_lane
    assert lane is not None
    assert lane.encoding is not None
    assert lane.encoding.channels == 1
    heard: list[int] = []
    for channels in (2, 1, 2):
        for _ in range(30):
            moment_s = 1000 + len(heard) / 100
            rig.audio.push(Sound(np.zeros(480, np.int16), moment_s).with_channels(channels))
            await asyncio.sleep(0)
            heard.append(lane.encoding.channels)
        assert heard[-1] == channels
        assert len(rig.audio.wanted) == 1


async def test_an_error_in_the_fan_out_ends_the_tape_and_nothing_else(rig: Rig) -> None:
    """After an error the tape leaves the fan-out, nothing is encoded for it, and it is reported."""
    with rig.tape._boundary:
        raise RuntimeError
    assert rig.video.wanted == []
    assert rig.audio.wanted == []
    assert rig.tape.recorder.problem is not None
    assert "restart" in str(rig.tape.recorder.problem)
    assert rig.counters.snapshot() == {"viewer faults": 1}


@pytest.mark.system
async def test_what_was_cut_off_is_mended_at_the_next_start(tmp_path: Path) -> None:
    """Another process repairs the last part while the new one is recorded."""
    shelf = Shelf(tmp_path / "tape")
    shelf.prepare()
    torn = shelf.path("wax-20261123T140000Z", EVENTS)
    torn.write_bytes(b"\x89MCAP0\r\n")
    rig = Rig(shelf.folder)
    rig.video.start()
    rig.tape.start()
    await async_until(lambda: ending_of(torn) == "mended")
    rig.tape.stop()
    rig.video.stop()


async def test_sound_is_left_out_where_it_is_not_to_be_recorded(tmp_path: Path) -> None:
    """Sound that is not to be recorded never reaches the recorder."""
    rig = Rig(tmp_path / "tape", sound=False)
    rig.video.start()
    rig.tape.start()
    assert not rig.tape.has_sound
    assert rig.audio.wanted == []
    rig.tape.stop()
    rig.video.stop()
