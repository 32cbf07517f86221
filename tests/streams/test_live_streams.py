"""One viewer under the live policies: what they are sent, and when it plays."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import av
import numpy as np
import pytest
from tests.open_boundary import OpenFence
from tests.turned_clock import TurnedClock

from wax.capture.source import BLOCK_SAMPLES, Sound
from wax.config.settings import AudioSettings, SyncSettings, VideoSettings
from wax.congestion.delivery import Delivery
from wax.encode.encoded import VIDEO_TIME_BASE, EncodedPicture
from wax.fanout.sound_hub import SoundHub
from wax.fanout.video_hub import VideoHub
from wax.fanout.video_lane import VideoLane
from wax.protocol import messages
from wax.streams.live import LiveService
from wax.sync.playout import PlayoutReport, StreamPlayout

if TYPE_CHECKING:
    from pydantic import BaseModel

    from wax.congestion.control import CongestionControl
    from wax.congestion.delivery import Train
    from wax.error_boundary import ErrorBoundary

SIZES = VideoSettings()
OPERATOR = SyncSettings(max_holdback_ms=50.0, max_skew_ms=100.0, least_audio_mu_ms=10)


@dataclass
class Testbed:
    """A viewer behind a link of `rate_bps`, everything real but time, encoders and the wire."""

    rate_bps: float = 20e6
    takes_hold_back: bool = True
    clock: TurnedClock = field(default_factory=lambda: TurnedClock(100.0))
    told: list[BaseModel] = field(default_factory=list)
    held_ms: list[float] = field(default_factory=list)
    boundary: ErrorBoundary = field(default_factory=OpenFence)

    def __post_init__(self) -> None:
        self.video = VideoHub(settings=SIZES, clock=self.clock)
        self.audio = SoundHub()
        service = LiveService(
            clock=self.clock,
            video_settings=SIZES,
            audio_settings=AudioSettings(),
            video=self.video,
            audio=self.audio,
        )
        self.streams = service.streams(self, SyncSettings())
        lanes = self.streams.lanes()
        assert isinstance(lanes.picture, VideoLane)
        self.lane, self.way = lanes.picture, lanes.way
        self.asked: list[str] = []
        self.sizes: list[str] = []
        self.left = 0
        self._free_s = 0.0
        self._feedback: list[tuple[float, Delivery]] = []
        self._silent = False

    # As a page.

    def send(self, message: BaseModel) -> None:
        self.told.append(message)

    def hold_back(self, least_ms: float) -> bool:
        self.held_ms.append(least_ms)
        return self.takes_hold_back

    def all(self, kind: type[BaseModel]) -> list[Any]:
        return [message for message in self.told if isinstance(message, kind)]

    # As encoders and wire.

    def begin(self, *, sound: bool = True) -> None:
        self.streams.connected()
        self.streams.ready()
        self.streams.want(sound=sound, picture=True, size="640x480", policy=None)

    async def run(self, seconds: float) -> None:
        """Film, encode what is wanted, send what the way lets go, and tell what came."""
        for tick in range(round(seconds * 100)):
            self.clock.time_s += 0.01
            now_s = self.clock.now_s()
            self.audio.push(Sound(np.zeros(BLOCK_SAMPLES, np.int16), now_s - 0.01))
            await asyncio.sleep(0)
            if tick % 2 == 0:
                self._wire(120, "audio", None)
            if tick % 4 == 0:
                for made in [self._picture(name, now_s) for name in self.video.wanted]:
                    self.video._fan_out(made)
            if self.way.free_in_s(None, now_s) <= 0.001 and (one := self.lane.take()) is not None:
                self.sizes.append(one.rendition)
                self._send(self.way, one)
            due = [one for at_s, one in self._feedback if at_s <= now_s]
            self._feedback = [one for one in self._feedback if one[0] > now_s]
            if due and not self._silent:
                self.way.delivered(due, now_s)

    def _picture(self, name: str, now_s: float) -> EncodedPicture:
        rendition = self.video._renditions[name]
        keyframe = rendition._keyframe.is_set()
        rendition._keyframe.clear()
        if keyframe:
            self.asked.append(name)
        mean = rendition.settings.bitrate_bps / rendition.settings.fps / 8
        packet: av.Packet[Any] = av.Packet(bytes(round(mean * (3 if keyframe else 1))))
        packet.pts = round(now_s * 90_000)
        packet.time_base = VIDEO_TIME_BASE
        return EncodedPicture(packet, name, keyframe, 0, now_s)

    def _send(self, way: CongestionControl, picture: EncodedPicture) -> None:
        size = picture.packet.size
        train: Train = way.train(size, self.clock.now_s())
        while size > 0:
            self._wire(min(size, train.payload_bytes) + 62, "video", train.number)
            size -= train.payload_bytes
        self.left += 1

    def _wire(self, size: int, kind: Any, train: int | None) -> None:
        now_s = self.clock.now_s()
        self.way.sent(size, now_s, is_media=True)
        self._free_s = max(self._free_s, now_s) + size * 8 / self.rate_bps
        came = Delivery(now_s, 5000 + self._free_s + 0.02, size, kind, train)
        self._feedback.append((self._free_s + 0.06, came))

    def report(self, sound_ms: float | None, picture_ms: float | None) -> None:
        self.clock.time_s += 0.25
        played_ms = self.clock.time_s * 1000
        self.streams.reported(
            PlayoutReport(
                sound=None
                if sound_ms is None
                else StreamPlayout(age_ms=sound_ms, concealed_ms=0.0, played_ms=played_ms),
                picture=None if picture_ms is None else StreamPlayout(age_ms=picture_ms),
            )
        )


TOP, *_, BOTTOM = (one.name for one in SIZES.renditions)


async def test_a_picture_starts_small_and_grows_at_once() -> None:
    """Before anything is known the smallest rendition goes; a fast link has the largest soon."""
    testbed = Testbed()
    testbed.begin()
    assert testbed.video.wanted == [BOTTOM]
    await testbed.run(2.0)
    assert testbed.video.wanted == [TOP]
    assert testbed.sizes[0] == BOTTOM
    assert testbed.sizes[-1] == TOP


async def test_a_thin_link_stays_with_what_it_carries() -> None:
    """A modem line gets the smallest rendition and long units of sound, without a queue."""
    testbed = Testbed(rate_bps=50e3)
    testbed.begin()
    await testbed.run(12.0)
    served = testbed.streams.status()
    assert served["rendition"] == BOTTOM
    assert served["sound_mu_ms"] == 60
    assert float(str(served["queue_ms"])) < 400


async def test_a_link_that_narrows_gets_a_fresh_start_with_less() -> None:
    """What the old link carried is given up at once; the new rendition begins by a keyframe."""
    testbed = Testbed(rate_bps=8e6)
    testbed.begin()
    await testbed.run(4.0)
    assert testbed.sizes[-1] == TOP
    testbed.rate_bps = 300e3
    testbed.sizes.clear()
    await testbed.run(4.0)
    later = [name for name in testbed.sizes if name != TOP]
    assert later
    assert testbed.sizes[-1] != TOP
    assert testbed.sizes == sorted(testbed.sizes, key=lambda name: name != TOP)


async def test_a_picture_that_lost_its_thread_is_helped_when_there_is_room() -> None:
    """After a way was closed for long one keyframe is asked for, not one a picture."""
    testbed = Testbed()
    testbed.begin()
    await testbed.run(3.0)
    testbed.lane._shed()
    testbed.lane._cut_layer = 0
    testbed.asked.clear()
    await testbed.run(1.5)
    assert 1 <= len(testbed.asked) <= 2
    assert not testbed.lane.is_cut


async def test_the_page_is_told_what_it_gets_when_that_changes() -> None:
    """Nothing is told before anything is known, news at once, and figures once a second at most."""
    testbed = Testbed()
    testbed.begin()
    assert not testbed.all(messages.Served)
    await testbed.run(10.0)
    told = testbed.all(messages.Served)
    assert told[-1].rendition == TOP
    assert told[-1].picture_hz == 30.0
    assert (told[-1].layers, told[-1].layers_made) == (3, 3)
    assert told[-1].reason == "as large as asked for"
    assert len(told) <= 14


async def test_the_picture_is_held_back_by_the_server_where_the_browser_takes_it() -> None:
    """The hold-back goes with the packets; the page's own buffer is then left alone."""
    testbed = Testbed()
    testbed.begin()
    for _ in range(8):
        testbed.report(sound_ms=120.0, picture_ms=40.0)
    assert testbed.held_ms[0] == 0.0
    assert max(testbed.held_ms) >= 70.0
    assert {one.picture_target_ms for one in testbed.all(messages.Playout)} == {None}


async def test_the_page_holds_the_picture_back_where_its_browser_does_not() -> None:
    """A browser without the header extension gets the hold-back as its buffer's target."""
    testbed = Testbed(takes_hold_back=False)
    testbed.begin()
    for _ in range(8):
        testbed.report(sound_ms=120.0, picture_ms=40.0)
    assert testbed.all(messages.Playout)[-1].picture_target_ms >= 70.0


async def test_nothing_to_hold_back_is_zero() -> None:
    """The operator sees the picture at once while the sound is at most 80 ms behind it."""
    testbed = Testbed()
    testbed.begin()
    testbed.streams.follow(OPERATOR, drives=True)
    for _ in range(8):
        testbed.report(sound_ms=85.0, picture_ms=10.0)
    assert set(testbed.held_ms) == {0.0}


@pytest.mark.parametrize("how", ["asked", "role"])
async def test_the_policy_changes_without_a_black_picture(how: str) -> None:
    """Asked for or with the role, a change of policy touches neither lanes nor renditions."""
    testbed = Testbed()
    testbed.begin()
    await testbed.run(2.0)
    for _ in range(6):
        testbed.report(sound_ms=160.0, picture_ms=60.0)
    lane, left = testbed.lane, testbed.left
    testbed.asked.clear()
    if how == "asked":
        testbed.streams.want(sound=True, picture=True, size="640x480", policy="video-first")
    else:
        testbed.streams.follow(SyncSettings(policy="video-first"), drives=False)
    assert testbed.all(messages.Playout)[-1].policy == "video-first"
    assert testbed.held_ms[-1] == 0.0
    await testbed.run(1.0)
    assert testbed.lane is lane
    assert testbed.left > left + 15
    assert not testbed.asked


async def test_who_drives_may_have_a_rendition_of_his_own() -> None:
    """In their turn an operator gets an own step between two others; after it nothing is left."""
    testbed = Testbed(rate_bps=0.75e6)
    shared = testbed.video.names
    testbed.video.start()
    try:
        testbed.begin()
        testbed.streams.follow(OPERATOR.model_copy(update={"own_rendition": True}), drives=True)
        await testbed.run(20.0)
        assert testbed.sizes[-1] not in shared
        assert testbed.video.wanted == [testbed.sizes[-1]]
        testbed.streams.follow(SyncSettings(), drives=False)
        await testbed.run(20.0)
        assert testbed.sizes[-1] in shared
        assert testbed.video.names == shared
    finally:
        testbed.video.stop()


async def test_a_wish_outlives_a_change_of_role() -> None:
    """A viewer who chose a policy keeps it in their turn, with the role's limits."""
    testbed = Testbed()
    testbed.begin()
    testbed.streams.want(sound=True, picture=True, size="640x480", policy="video-first")
    testbed.streams.follow(OPERATOR, drives=True)
    assert testbed.all(messages.Playout)[-1].policy == "video-first"
    testbed.streams.want(sound=True, picture=True, size="640x480", policy=None)
    assert testbed.all(messages.Playout)[-1].policy == "audio-master"


async def test_a_fixed_media_unit_is_kept() -> None:
    """A unit that the configuration fixes is not the link's to choose."""
    testbed = Testbed()
    testbed.begin()
    testbed.streams.follow(SyncSettings(audio_mu_ms=120), drives=False)
    await testbed.run(1.0)
    assert testbed.streams.status()["sound_mu_ms"] == 120


async def test_what_is_not_wanted_is_not_sent() -> None:
    """Without picture and sound the encoders rest; a smaller size is the largest that is sent."""
    testbed = Testbed()
    testbed.begin()
    await testbed.run(2.0)
    testbed.streams.want(sound=True, picture=True, size="320x240", policy=None)
    await testbed.run(2.0)
    assert all(name.startswith("320x240") for name in testbed.video.wanted)
    testbed.streams.want(sound=False, picture=False, size="320x240", policy=None)
    await testbed.run(0.5)
    assert (testbed.video.wanted, testbed.audio.wanted) == ([], [])
    testbed.streams.release()
    testbed.streams.release()
