"""One rendition encodes while it is wanted, and reports its load."""

from __future__ import annotations

import threading
from contextlib import suppress
from queue import Empty, Queue
from typing import TYPE_CHECKING

import numpy as np
import pytest
from tests.turned_clock import TurnedClock

from wax.capture.newest_slot import NewestSlot
from wax.capture.source import Picture
from wax.config.video import RenditionSettings
from wax.encode.encoded import EncodedPicture
from wax.encode.rendition import Rendition

if TYPE_CHECKING:
    from collections.abc import Iterator

SETTINGS = RenditionSettings(width=64, height=48, fps=30, bitrate_bps=100_000)
TAKES_S = 0.01
"""The time that each picture takes, so that 30 a second are 0.3 of a core."""


class Watched(NewestSlot[Picture]):
    """Records the number of the picture after which a newer one was last requested.

    `begun` is how often the rendition has begun to encode.
    """

    asked = -1
    begun = 0

    @property
    def count(self) -> int:
        self.begun += threading.current_thread() is not threading.main_thread()
        return super().count

    def newer_than(self, number: int, timeout_s: float) -> tuple[int, Picture] | None:
        self.asked = number
        return super().newer_than(number, timeout_s)


class Studio:
    """A rendition with an encoder of known speed, and a camera."""

    camera_fps = 30

    def __init__(self) -> None:
        self.clock = TurnedClock()
        self.slot = Watched()
        self.made: Queue[EncodedPicture] = Queue()
        self.encoders = 0
        self.rendition = Rendition(
            settings=SETTINGS,
            keyframe_interval_s=10.0,
            make_encoder=self._made,
            slot=self.slot,
            clock=self.clock,
            deliver=self.made.put,
        )

    def _made(self) -> Studio:
        self.encoders += 1
        return self

    def pause(self) -> None:
        """Pause the rendition until it has noticed, and resume it."""
        before = self.slot.begun
        while self.slot.begun == before:
            self.rendition.want(False)
            self.slot.put(Picture(np.zeros((72, 64), np.uint8), 50.0))
            self.rendition.want(True)
        self.made.queue.clear()

    def encode(self, picture: Picture, *, keyframe: bool) -> EncodedPicture | None:
        self.clock.time_s += TAKES_S
        return EncodedPicture(b"x", 1, SETTINGS.name, keyframe, 0, picture.captured_s)

    def film(self, pictures: int) -> list[EncodedPicture]:
        """Deliver pictures until this many are encoded, each once the last one is."""
        return [self._next() for _ in range(pictures)]

    def keyframes(self, pictures: int) -> list[int]:
        """Film this many, at twice the coalescing interval; return which are keyframes."""
        return [at for at, one in enumerate(self.film(pictures)) if one.keyframe]

    def _next(self) -> EncodedPicture:
        for _ in range(100):
            taken_s = 50.0 + self.slot.count / self.camera_fps
            self.slot.put(Picture(np.zeros((72, 64), np.uint8), taken_s))
            while True:
                wants_the_next = self.slot.asked == self.slot.count
                with suppress(Empty):
                    return self.made.get(timeout=0.001)
                if wants_the_next:  # pictures taken before it started are not encoded
                    break
        raise AssertionError("nothing is encoded")


@pytest.fixture
def studio() -> Iterator[Studio]:
    made = Studio()
    made.rendition.start()
    yield made
    made.rendition.stop(5.0)


def test_the_load_is_what_encoding_takes(studio: Studio) -> None:
    """The load is the share of a core while encoding, and 0 while paused."""
    assert studio.rendition.load == 0.0
    studio.rendition.want(True)
    studio.film(20)
    assert 0.1 < studio.rendition.load < 0.3
    studio.film(100)
    assert studio.rendition.load == pytest.approx(TAKES_S * SETTINGS.fps, rel=0.05)
    studio.rendition.want(False)
    assert studio.rendition.load == 0.0


def test_the_load_is_measured_against_the_camera(studio: Studio) -> None:
    """A camera at a third of the rendition's rate leaves three times as long for a picture."""
    studio.camera_fps = 10
    studio.rendition.want(True)
    studio.film(120)
    assert studio.rendition.load == pytest.approx(TAKES_S * 10, rel=0.05)


def test_after_a_rest_comes_a_keyframe(studio: Studio) -> None:
    """The first picture after a pause is a keyframe; later ones are on request."""
    studio.rendition.want(True)
    assert studio.keyframes(60) == [0]
    studio.rendition.want(False)
    studio.rendition.want(True)
    studio.clock.time_s += 1.0
    assert len(studio.keyframes(60)) == 1


def test_a_short_pause_opens_no_encoder(studio: Studio) -> None:
    studio.rendition.want(True)
    studio.film(1)
    studio.pause()
    studio.clock.time_s += 1.0
    studio.film(1)
    assert studio.encoders == 1


def test_a_long_pause_frees_the_encoder(studio: Studio, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("wax.encode.rendition._KEEP_S", 0.0)
    studio.rendition.want(True)
    studio.film(1)
    while studio.encoders == 1:
        studio.pause()


def test_one_keyframe_serves_the_interval_and_who_asks(studio: Studio) -> None:
    """One keyframe serves a request and an interval that are due together."""
    studio.rendition.want(True)
    assert studio.keyframes(60) == [0]
    studio.rendition.request_keyframe()
    assert studio.keyframes(60) == [0]
    studio.clock.time_s += 20.0  # twice the interval
    studio.rendition.request_keyframe()
    assert studio.keyframes(60) == [0]
    studio.rendition.request_keyframe()
    studio.rendition.request_keyframe()
    assert studio.keyframes(60) == [0]


def test_whoever_asks_all_the_time_gets_a_keyframe_a_second(studio: Studio) -> None:
    """After a burst requests get one keyframe a second, but an operator's never waits."""
    studio.rendition.want(True)

    def asked(times: int, *, is_urgent: bool) -> int:
        made = 0
        for _ in range(times):
            studio.rendition.request_keyframe(is_urgent=is_urgent)
            studio.clock.time_s += 0.31
            made += studio.film(1)[0].keyframe
        return made

    assert asked(30, is_urgent=False) in (14, 15, 16)  # in 9 s, and six at first
    assert asked(5, is_urgent=True) == 5


def test_a_pause_gives_no_further_keyframe(studio: Studio) -> None:
    """After a burst, the first picture after a pause waits as a request does."""
    studio.rendition.want(True)
    for _ in range(8):
        studio.rendition.request_keyframe()
        studio.clock.time_s += 0.31
        studio.film(1)
    studio.pause()
    with pytest.raises(AssertionError, match="nothing is encoded"):
        studio.film(1)
    studio.clock.time_s += 1.0
    assert studio.film(1)[0].keyframe
