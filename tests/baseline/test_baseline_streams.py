"""One viewer under the thesis's policy: captured, acknowledged and sent units."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from tests.open_boundary import OpenFence
from tests.turned_clock import TurnedClock

from wax.baseline.streams import BaselineService, BaselineStreams, thesis_video
from wax.baseline.unit_hub import UnitHub
from wax.baseline.unit_lane import UnitLane
from wax.capture.source import BLOCK_SAMPLES, Sound
from wax.config.sync import SyncSettings
from wax.config.thesis import ThesisSettings
from wax.config.video import VideoSettings
from wax.encode.encoded import EncodedPicture, SoundUnit
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
class Rig:
    """A viewer; only time, the encoders' threads and the wire are simulated."""

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
        self._take(self.streams.make_lanes())

    def send(self, message: BaseModel) -> None:
        self.told.append(message)

    def set_playout_delay(self, least_ms: float) -> bool:
        raise AssertionError("the thesis's roll-back is the server's work")

    def _take(self, lanes: Lanes) -> None:
        assert isinstance(lanes.picture, UnitLane)
        assert isinstance(lanes.sound, UnitLane)
        self.picture, self.sound = lanes.picture, lanes.sound

    async def capture(self, seconds: float, *, acknowledge: bool = True) -> list[Any]:
        """Advance time and return what was sent, in order; the link takes no time."""
        left: list[Any] = []
        for _ in range(round(seconds * 50)):
            self.clock.time_s += 0.02
            silence = np.zeros(BLOCK_SAMPLES, np.int16)
            for ago_s in (0.02, 0.01):
                self.audio.push(Sound(silence, self.clock.time_s - ago_s))
            if round(self.clock.time_s * 50) % 5 == 0:
                self.video._fan_out(_picture(self.clock.time_s))
            await asyncio.sleep(0)  # units from the capture thread are on their way
            left += await self.leave(acknowledge=acknowledge)
        return left

    async def leave(self, *, acknowledge: bool) -> list[Any]:
        left = []
        for kind, lane in (("audio", self.sound), ("video", self.picture)):
            packets = _waiting(lane)
            left += packets
            if packets and acknowledge:
                self.streams.received(kind, packets[-1].pts % 2**32)  # type: ignore[arg-type]
        return left

    @property
    def status(self) -> dict[str, Any]:
        return self.streams.status().entry


def _picture(captured_s: float) -> EncodedPicture:
    pts = round(captured_s * 90_000)
    return EncodedPicture(b"picture", pts, NAME, keyframe=True, layer=0, captured_s=captured_s)


def _waiting(lane: UnitLane[Any]) -> list[Any]:
    packets = list(lane._queue)
    lane._queue.clear()
    return packets


@pytest.fixture
async def rig() -> Any:
    made = Rig()
    made.audio.start()
    yield made
    made.streams.release()


async def test_nothing_leaves_before_the_page_wants_it(rig: Rig) -> None:
    """Nothing is sent that the page cannot acknowledge yet, since it would count as lost."""
    rig.streams.connected()
    rig.streams.ready()
    assert await rig.capture(2.0) == []
    assert rig.audio.wanted == []


async def test_sound_leaves_as_whole_units_and_the_picture_is_rolled_back(rig: Rig) -> None:
    """A unit of half a second is sent at once; in step, the picture is half a second old."""
    rig.streams.want(sound=True, picture=True, size=SIZE, policy=None)
    left = await rig.capture(8.0)
    sounds = [one for one in left if not isinstance(one, EncodedPicture)]
    assert len(sounds) % 5 == 0
    assert set(np.diff([one.pts for one in sounds])) == {800}
    assert rig.status["mode"] == "synchronised"
    assert rig.status["pictures_cached"] == 4
    began_s = rig.clock.time_s
    (picture, *_) = [p for p in await rig.capture(0.2) if isinstance(p, EncodedPicture)]
    assert began_s - picture.captured_s == pytest.approx(0.4, abs=0.11)
    assert rig.streams._payloads.keys() <= {
        (unit.stream, unit.number) for unit in rig.streams._sender._cache.pictures
    }


async def test_nothing_newer_leaves_before_the_page_acknowledges(rig: Rig) -> None:
    """One unit of each stream is in flight until it is acknowledged."""
    rig.streams.want(sound=True, picture=True, size=SIZE, policy=None)
    left = await rig.capture(0.9, acknowledge=False)
    assert sum(isinstance(one, EncodedPicture) for one in left) == 1
    assert len(left) == 6
    assert rig.status["sent"] == 2


async def test_a_link_that_never_answers_ends_in_fail_safe(rig: Rig) -> None:
    """Fail-safe mode is reported to the page and timed, and skipped units are freed."""
    rig.streams.want(sound=True, picture=True, size=SIZE, policy=None)
    await rig.capture(12.0, acknowledge=False)
    assert rig.status["mode"] == "fail-safe"
    assert rig.status["fail_safe_s"] > 8
    assert rig.status["lost"] >= 2
    assert rig.audio.dropped > 0
    assert rig.video.dropped > 50
    assert len(rig.streams._payloads) <= 6
    (*_, last) = rig.told
    assert isinstance(last, messages.Playout)
    assert (last.policy, last.sound_target_ms, last.picture_target_ms) == ("thesis", None, 0.0)
    assert last.reason.code == "thesis.fail_safe"


async def test_only_the_packet_that_ends_a_unit_acknowledges_it(rig: Rig) -> None:
    """Any other time stamp from a page changes nothing."""
    rig.streams.want(sound=True, picture=False, size=SIZE, policy=None)
    (*_, last) = await rig.capture(0.7, acknowledge=False)
    for pts in (0, -1, last.pts - 800, last.pts + 800, last.pts + 1):
        rig.streams.received("audio", pts % 2**32)
        rig.streams.received("video", pts % 2**32)
    assert await rig.capture(0.4, acknowledge=False) == []
    rig.streams.received("audio", last.pts % 2**32)
    assert len(await rig.leave(acknowledge=False)) == 5


async def test_the_page_is_told_which_packets_end_a_unit(rig: Rig) -> None:
    """After the first unit the page knows where it ended; other ends are whole lengths away."""
    rig.streams.want(sound=True, picture=False, size=SIZE, policy=None)
    assert rig.streams.units is None
    left = await rig.capture(2.0)
    units = rig.streams.units
    assert units is not None
    assert {(units.last_pts - one.pts) % units.length for one in left[4::5]} == {0}


async def test_a_fresh_peer_begins_anew(rig: Rig) -> None:
    """After a reconnect nothing of the old link or its units in flight counts."""
    rig.streams.want(sound=True, picture=True, size=SIZE, policy=None)
    await rig.capture(2.0, acknowledge=False)
    rig._take(rig.streams.make_lanes())
    assert await rig.capture(1.0) == []
    rig.streams.want(sound=True, picture=True, size=SIZE, policy=None)
    assert len(await rig.capture(2.0)) > 20
    assert rig.status["lost"] == 0


async def test_a_client_that_buffers_more_sound_gets_an_older_picture(rig: Rig) -> None:
    """If sound plays 200 ms after the picture, the picture is rolled back by that (5.3.1)."""
    rig.streams.want(sound=True, picture=True, size=SIZE, policy=None)
    await rig.capture(4.0)
    before_ms = rig.status["rollback_ms"]
    report = PlayoutReport(sound=StreamPlayout(age_ms=800.0), picture=StreamPlayout(age_ms=600.0))
    for _ in range(5):
        rig.streams.reported(report)
    assert rig.status["rollback_ms"] == before_ms + 200


async def test_release_ends_it_all(rig: Rig) -> None:
    """After a release, even a repeated one, nothing is subscribed, scheduled or sent."""
    rig.streams.want(sound=True, picture=True, size=SIZE, policy=None)
    (*_, last) = await rig.capture(0.6, acknowledge=False)
    rig.streams.release()
    rig.streams.release()
    told = len(rig.told)
    rig.streams.want(sound=True, picture=True, size=SIZE, policy=None)
    for kind in ("audio", "video"):
        rig.streams.received(kind, last.pts % 2**32)
    rig.streams.round_trip(0.1)
    rig.streams.reported(PlayoutReport(sound=None, picture=None))
    assert await rig.capture(1.0) == []
    assert rig.audio.wanted == []
    assert rig.video.wanted == []
    assert len(rig.told) == told
    assert rig.streams._timer is None


def test_sound_is_needed_while_anybody_listens() -> None:
    """Until somebody listens, and after the last has left, the source may rest."""
    hub = UnitHub(mu_ms=SETTINGS.audio_mu_ms)
    first: list[SoundUnit] = []
    second: list[SoundUnit] = []
    needed = [hub.needed.is_set()]
    hub.listen(first.append, OpenFence())
    hub.skip(Sound(np.zeros(7, np.int16), 1.0))
    for act in (
        partial(hub.listen, second.append, OpenFence()),
        partial(hub.leave, first.append),
        partial(hub.leave, second.append),
    ):
        needed.append(hub.needed.is_set())
        act()
    assert [*needed, hub.needed.is_set()] == [False, True, True, True, False]
    assert hub.counts() == {"captured": 1, "encoded": 0}


async def test_two_channels_are_mixed_into_the_thesiss_one() -> None:
    """A stereo microphone gives the mean of both channels, as in mono."""
    units: list[list[bytes]] = []
    left, right = (
        np.random.default_rng(3).integers(-9000, 9000, (2, 50 * BLOCK_SAMPLES)).astype(np.int16)
    )
    for samples in (np.column_stack((left, right)), ((left + right) // 2).astype(np.int16)):
        heard: list[SoundUnit] = []
        hub = UnitHub(mu_ms=SETTINGS.audio_mu_ms)
        hub.start()
        hub.listen(heard.append, OpenFence())
        for number in range(50):
            part = samples[number * BLOCK_SAMPLES : (number + 1) * BLOCK_SAMPLES]
            hub.push(Sound(part, 1.0 + number / 100))
        await asyncio.sleep(0)
        units.append([packet.data for unit in heard for packet in unit.packets])
    assert units[0] == units[1]
    assert len(units[0]) > 0
