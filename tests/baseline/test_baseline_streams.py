"""One viewer under the thesis's policy: what is captured, acknowledged and put on the wire."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import av
import numpy as np
import pytest
from tests.open_boundary import OpenFence
from tests.turned_clock import TurnedClock

from wax.baseline.streams import BaselineService, BaselineStreams, thesis_video
from wax.baseline.unit_hub import UnitHub
from wax.baseline.unit_lane import UnitLane
from wax.capture.source import BLOCK_SAMPLES, Sound
from wax.config.settings import SyncSettings, VideoSettings
from wax.config.thesis import ThesisSettings
from wax.encode.encoded import VIDEO_TIME_BASE, EncodedPicture
from wax.fanout.video_hub import VideoHub
from wax.protocol import messages
from wax.sync.playout import PlayoutReport, StreamPlayout

if TYPE_CHECKING:
    from pydantic import BaseModel

    from wax.error_boundary import ErrorBoundary
    from wax.streams.interface import Lanes


SETTINGS = ThesisSettings()
SIZE = "166x130"
NAME = thesis_video(VideoSettings(), SETTINGS).renditions[0].name


@dataclass
class Testbed:
    """A viewer with everything real but time, the encoders' threads and the wire."""

    clock: TurnedClock = field(default_factory=TurnedClock)
    told: list[BaseModel] = field(default_factory=list)
    boundary: ErrorBoundary = field(default_factory=OpenFence)

    def __post_init__(self) -> None:
        video = thesis_video(VideoSettings(), SETTINGS)
        self.video = VideoHub(settings=video, clock=self.clock)
        self.audio = UnitHub(mu_ms=SETTINGS.audio_mu_ms)
        self.service = BaselineService(
            clock=self.clock, settings=SETTINGS, video=self.video, audio=self.audio
        )
        self.streams: BaselineStreams = self.service.streams(self, SyncSettings())
        self._take(self.streams.lanes())

    def send(self, message: BaseModel) -> None:
        self.told.append(message)

    def hold_back(self, least_ms: float) -> bool:
        raise AssertionError("the thesis's roll-back is the server's work")

    def _take(self, lanes: Lanes) -> None:
        assert isinstance(lanes.picture, UnitLane)
        assert isinstance(lanes.sound, UnitLane)
        self.picture, self.sound = lanes.picture, lanes.sound

    async def capture(self, seconds: float, *, acknowledge: bool = True) -> list[Any]:
        """Let time pass; return what left, in order. The link takes no time."""
        left: list[Any] = []
        for _ in range(round(seconds * 50)):
            self.clock.time_s += 0.02
            silence = np.zeros(BLOCK_SAMPLES, np.int16)
            for ago_s in (0.02, 0.01):
                self.audio.push(Sound(silence, self.clock.time_s - ago_s))
            if round(self.clock.time_s * 50) % 5 == 0:
                self.video._fan_out(_picture(self.clock.time_s))
            await asyncio.sleep(0)  # what comes from the capture's thread is on its way
            left += await self.leave(acknowledge=acknowledge)
        return left

    async def leave(self, *, acknowledge: bool) -> list[Any]:
        left = []
        for kind, lane in (("audio", self.sound), ("video", self.picture)):
            packets = _waiting(lane)
            left += packets
            if packets and acknowledge:
                self.streams.received(kind, (packets[-1].packet.pts or 0) % 2**32)  # type: ignore[arg-type]
        return left

    @property
    def status(self) -> dict[str, Any]:
        return self.streams.status()


def _picture(captured_s: float) -> EncodedPicture:
    packet: av.Packet[Any] = av.Packet(b"picture")
    packet.pts = round(captured_s * 90_000)
    packet.time_base = VIDEO_TIME_BASE
    return EncodedPicture(
        packet=packet, rendition=NAME, keyframe=True, layer=0, captured_s=captured_s
    )


def _waiting(lane: UnitLane[Any]) -> list[Any]:
    packets = list(lane._queue)
    lane._queue.clear()
    return packets


@pytest.fixture
async def testbed() -> Any:
    made = Testbed()
    made.audio.start()
    yield made
    made.streams.release()


async def test_nothing_leaves_before_the_page_wants_it(testbed: Testbed) -> None:
    """What nobody can acknowledge yet is not sent: it would count as lost."""
    testbed.streams.connected()
    testbed.streams.ready()
    assert await testbed.capture(2.0) == []
    assert testbed.audio.wanted == []


async def test_sound_leaves_as_whole_units_and_the_picture_is_rolled_back(testbed: Testbed) -> None:
    """A unit of half a second leaves at once; in step, the picture leaves half a second old."""
    testbed.streams.want(sound=True, picture=True, size=SIZE, policy=None)
    left = await testbed.capture(8.0)
    sounds = [one for one in left if not isinstance(one, EncodedPicture)]
    assert len(sounds) % 5 == 0
    assert set(np.diff([one.pts for one in sounds])) == {800}
    assert testbed.status["mode"] == "synchronised"
    assert testbed.status["pictures_cached"] == 4
    began_s = testbed.clock.time_s
    (picture, *_) = [p for p in await testbed.capture(0.2) if isinstance(p, EncodedPicture)]
    assert began_s - picture.captured_s == pytest.approx(0.4, abs=0.11)
    assert testbed.streams._payloads.keys() <= {
        (unit.stream, unit.number) for unit in testbed.streams._sender._cache.pictures
    }


async def test_nothing_newer_leaves_before_the_page_acknowledges(testbed: Testbed) -> None:
    """To send means to be received: one unit of each stream is under way, and no more."""
    testbed.streams.want(sound=True, picture=True, size=SIZE, policy=None)
    left = await testbed.capture(0.9, acknowledge=False)
    assert sum(isinstance(one, EncodedPicture) for one in left) == 1
    assert len(left) == 6
    assert testbed.status["sent"] == 2


async def test_a_link_that_never_answers_ends_in_fail_safe(testbed: Testbed) -> None:
    """It is told to the page, counted in seconds, and what was skipped is not kept."""
    testbed.streams.want(sound=True, picture=True, size=SIZE, policy=None)
    await testbed.capture(12.0, acknowledge=False)
    assert testbed.status["mode"] == "fail-safe"
    assert testbed.status["fail_safe_s"] > 8
    assert testbed.status["lost"] >= 2
    assert testbed.audio.dropped > 0
    assert testbed.video.dropped > 50
    assert len(testbed.streams._payloads) <= 6
    (*_, last) = testbed.told
    assert isinstance(last, messages.Playout)
    assert (last.policy, last.sound_target_ms, last.picture_target_ms) == ("thesis", None, 0.0)
    assert last.reason.startswith("fail-safe: ")


async def test_only_the_packet_that_ends_a_unit_acknowledges_it(testbed: Testbed) -> None:
    """Any other time that a page may send changes nothing."""
    testbed.streams.want(sound=True, picture=False, size=SIZE, policy=None)
    (*_, last) = await testbed.capture(0.7, acknowledge=False)
    for pts in (0, -1, last.pts - 800, last.pts + 800, last.pts + 1):
        testbed.streams.received("audio", pts % 2**32)
        testbed.streams.received("video", pts % 2**32)
    assert await testbed.capture(0.4, acknowledge=False) == []
    testbed.streams.received("audio", last.pts % 2**32)
    assert len(await testbed.leave(acknowledge=False)) == 5


async def test_the_page_is_told_which_packets_end_a_unit(testbed: Testbed) -> None:
    """From the first unit on; every other ends a whole number of lengths away."""
    testbed.streams.want(sound=True, picture=False, size=SIZE, policy=None)
    assert testbed.streams.units is None
    left = await testbed.capture(2.0)
    units = testbed.streams.units
    assert units is not None
    assert {(units.last_pts - one.pts) % units.length for one in left[4::5]} == {0}


async def test_a_fresh_peer_begins_anew(testbed: Testbed) -> None:
    """After a reconnect nothing is known of the link, and nothing of the old peer is waited for."""
    testbed.streams.want(sound=True, picture=True, size=SIZE, policy=None)
    await testbed.capture(2.0, acknowledge=False)
    testbed._take(testbed.streams.lanes())
    assert await testbed.capture(1.0) == []
    testbed.streams.want(sound=True, picture=True, size=SIZE, policy=None)
    assert len(await testbed.capture(2.0)) > 20
    assert testbed.status["lost"] == 0


async def test_a_client_that_buffers_more_sound_gets_an_older_picture(testbed: Testbed) -> None:
    """Sound reported 200 ms after the picture rolls the picture back by as much (5.3.1)."""
    testbed.streams.want(sound=True, picture=True, size=SIZE, policy=None)
    await testbed.capture(4.0)
    before_ms = testbed.status["rollback_ms"]
    report = PlayoutReport(sound=StreamPlayout(age_ms=800.0), picture=StreamPlayout(age_ms=600.0))
    for _ in range(5):
        testbed.streams.reported(report)
    assert testbed.status["rollback_ms"] == before_ms + 200


async def test_release_ends_it_all(testbed: Testbed) -> None:
    """Nothing is listened to, timed or told after a viewer has parted, however often that is."""
    testbed.streams.want(sound=True, picture=True, size=SIZE, policy=None)
    (*_, last) = await testbed.capture(0.6, acknowledge=False)
    testbed.streams.release()
    testbed.streams.release()
    told = len(testbed.told)
    testbed.streams.want(sound=True, picture=True, size=SIZE, policy=None)
    for kind in ("audio", "video"):
        testbed.streams.received(kind, (last.packet.pts or 0) % 2**32)
    testbed.streams.round_trip(0.1)
    testbed.streams.reported(PlayoutReport(sound=None, picture=None))
    assert await testbed.capture(1.0) == []
    assert testbed.audio.wanted == []
    assert testbed.video.wanted == []
    assert len(testbed.told) == told
    assert testbed.streams._timer is None
