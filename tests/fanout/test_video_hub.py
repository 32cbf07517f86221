"""The fan-out of the picture: encoded once, only while wanted, keyframes coalesced."""

from __future__ import annotations

import asyncio
import threading
from time import monotonic
from typing import TYPE_CHECKING

import numpy as np
import pytest
from tests.open_boundary import OpenFence
from tests.turned_clock import TurnedClock

from wax.capture.source import Picture
from wax.clock import SystemClock
from wax.config.video import RenditionSettings, VideoSettings
from wax.encode.encoded import EncodedPicture
from wax.fanout.video_hub import VideoHub

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from wax.fanout.video_lane import VideoLane

SETTINGS = VideoSettings(
    renditions=[
        RenditionSettings(width=64, height=48, fps=30, bitrate_bps=100_000),
        RenditionSettings(width=32, height=32, fps=15, bitrate_bps=50_000),
    ]
)
BIG, SMALL = (one.name for one in SETTINGS.renditions)
OWN = RenditionSettings(width=64, height=48, fps=30, bitrate_bps=70_000)


class Camera:
    """Puts pictures into a hub, 1/30 s of capture time apart, faster than real time."""

    def __init__(self, hub: VideoHub) -> None:
        self.hub = hub
        self._taken_s = 50.0
        self._random = np.random.default_rng(4)

    def picture(self) -> None:
        i420 = self._random.integers(0, 255, (72, 64), dtype=np.uint8)
        self.hub.slot.put(Picture(i420, self._taken_s))
        self._taken_s += 1 / 30


@pytest.fixture
async def hub() -> AsyncIterator[VideoHub]:
    found = VideoHub(settings=SETTINGS, clock=SystemClock())
    found.start()
    yield found
    found.stop()


async def _next(camera: Camera, lane: VideoLane) -> EncodedPicture:
    """Film until the lane has a picture.

    A keyframe that comes after newer pictures of the old rendition is not taken; the streams ask
    for another then.
    """
    async with asyncio.timeout(5):
        if lane.is_waiting:
            camera.hub.request_keyframe(lane)
        while (picture := lane.pop_next()) is None:
            camera.picture()
            await asyncio.sleep(0.002)
    return picture


async def test_two_viewers_share_one_encoder(hub: VideoHub) -> None:
    """Two lanes of one rendition get the very same packets, encoded once."""
    camera, a, b = Camera(hub), hub.add(OpenFence()), hub.add(OpenFence())
    hub.choose(a, BIG)
    hub.choose(b, BIG)
    pictures, shared = [], []
    for _ in range(5):
        pictures.append(await _next(camera, a))
        shared.append(b.pop_next())
    assert [one.data for one in pictures] == [one and one.data for one in shared]
    assert pictures[0].keyframe


async def test_what_nobody_wants_is_not_encoded(hub: VideoHub) -> None:
    """Without a viewer nothing is encoded, nor after the last one has left."""
    camera = Camera(hub)
    for _ in range(10):
        camera.picture()
        await asyncio.sleep(0.002)
    assert (hub.wanted, hub.counts()[BIG]) == ([], 0)
    lane = hub.add(OpenFence())
    hub.choose(lane, BIG)
    await _next(camera, lane)
    hub.choose(lane, None)
    assert hub.wanted == []
    await asyncio.sleep(0.05)
    encoded = hub.counts()[BIG]
    for _ in range(10):
        camera.picture()
        await asyncio.sleep(0.002)
    assert hub.counts()[BIG] <= encoded + 1
    assert hub.counts()[SMALL] == 0


async def test_the_pictures_are_needed_while_any_rendition_is(hub: VideoHub) -> None:
    """From the first lane that wants a picture to the last, a source may not rest."""
    assert not hub.slot.needed.is_set()
    a, b = hub.add(OpenFence()), hub.add(OpenFence())
    assert not hub.slot.needed.is_set()
    hub.choose(a, BIG)
    hub.choose(b, SMALL)
    hub.choose(a, None)
    assert hub.slot.needed.is_set()
    hub.remove(b)
    assert not hub.slot.needed.is_set()


async def test_a_joiner_gets_a_keyframe_and_the_crowd_few(hub: VideoHub) -> None:
    """A viewer who joins can decode at once, yet many requests become one keyframe."""
    camera, first = Camera(hub), hub.add(OpenFence())
    hub.choose(first, BIG)
    seen = [await _next(camera, first) for _ in range(3)]
    started_s = monotonic()
    second = hub.add(OpenFence())
    hub.choose(second, BIG)
    while (joined := second.pop_next()) is None:
        for _ in range(20):
            hub.request_keyframe(first)
        seen.append(await _next(camera, first))
    while monotonic() - started_s < 0.65:
        hub.request_keyframe(first)
        seen.append(await _next(camera, first))
    # The one at the beginning, the joiner's, and one each 0.3 s.
    most = 3 + (monotonic() - started_s) / 0.3
    assert joined.keyframe
    assert 2 <= sum(one.keyframe for one in seen) <= most


async def test_a_slower_rendition_skips_pictures(hub: VideoHub) -> None:
    """A rendition of half the frame rate encodes every second picture; one late, it catches up."""
    camera, lane = Camera(hub), hub.add(OpenFence())
    hub.choose(lane, SMALL)
    await _next(camera, lane)
    taken_s = [(await _next(camera, lane)).captured_s for _ in range(21)]
    assert taken_s[-1] - taken_s[0] >= 19 * 2 / 30 - 1e-6


async def test_a_change_of_size_has_no_gap(hub: VideoHub) -> None:
    """Both sizes are encoded until the new one's keyframe is there, then only the new one."""
    camera, lane = Camera(hub), hub.add(OpenFence())
    hub.choose(lane, BIG)
    await _next(camera, lane)
    hub.choose(lane, SMALL)
    assert hub.wanted == [BIG, SMALL]
    async with asyncio.timeout(10):
        while (await _next(camera, lane)).rendition == BIG:
            pass
    assert hub.wanted == [SMALL]
    assert {(await _next(camera, lane)).rendition for _ in range(4)} == {SMALL}


async def test_what_was_dropped_stays_counted(hub: VideoHub) -> None:
    """When a slow viewer is removed, even twice, what their lane dropped still counts."""
    camera, quick, slow = Camera(hub), hub.add(OpenFence()), hub.add(OpenFence())
    hub.choose(quick, BIG)
    hub.choose(slow, BIG)
    while slow.dropped < 3:
        await _next(camera, quick)
    before = hub.dropped
    assert before >= 3
    hub.remove(slow)
    hub.remove(slow)
    assert hub.dropped == before


def _encoding() -> set[threading.Thread]:
    return {one for one in threading.enumerate() if one.name.startswith("encode")}


async def test_a_rendition_of_ones_own_lives_while_it_is_wanted(hub: VideoHub) -> None:
    """A provided rendition is encoded while somebody uses it; then its thread ends."""
    camera, a, b = Camera(hub), hub.add(OpenFence()), hub.add(OpenFence())
    shared = _encoding()
    hub.provide(OWN)
    hub.provide(OWN)
    for lane in (a, b):
        hub.choose(lane, OWN.name)
        assert (await _next(camera, lane)).rendition == OWN.name
    assert hub.names == [BIG, SMALL, OWN.name]
    assert hub.sizes == ["64x48", "32x32"]
    (thread,) = _encoding() - shared
    hub.remove(a)
    assert hub.wanted == [OWN.name]
    hub.choose(b, SMALL)
    while (await _next(camera, b)).rendition != SMALL:
        assert hub.wanted == [SMALL, OWN.name]
    assert hub.names == [BIG, SMALL]
    await asyncio.to_thread(thread.join, 5)
    assert _encoding() == shared
    hub.provide(OWN)
    hub.choose(b, OWN.name)
    async with asyncio.timeout(5):
        while (await _next(camera, b)).rendition != OWN.name:
            pass


async def test_what_is_shared_is_not_provided_anew(hub: VideoHub) -> None:
    """A configured rendition is neither replaced nor removed when unused."""
    camera, lane, threads = Camera(hub), hub.add(OpenFence()), _encoding()
    hub.provide(SETTINGS.renditions[0])
    hub.choose(lane, BIG)
    await _next(camera, lane)
    hub.remove(lane)
    assert hub.names == [BIG, SMALL]
    assert _encoding() == threads


@pytest.mark.parametrize(("cores", "has_room"), [(1.0, False), (2.0, True), (0.5, False)])
async def test_there_is_room_while_half_the_cores_suffice(
    monkeypatch: pytest.MonkeyPatch, cores: float, has_room: bool
) -> None:
    """There is room for a rendition if all together use at most half of the machine."""

    class Slow:
        """Takes 10 ms for each picture, which at 30 a second are 0.3 of a core."""

        def encode(self, picture: Picture, *, keyframe: bool) -> EncodedPicture | None:
            clock.time_s += 0.01
            return EncodedPicture(b"x", 1, BIG, keyframe, 0, picture.captured_s)

    monkeypatch.setattr("wax.machine.cores.usable", lambda: cores)
    clock = TurnedClock()
    hub = VideoHub(settings=SETTINGS, clock=clock, make_encoder=lambda _: Slow())
    hub.start()
    try:
        camera, lane = Camera(hub), hub.add(OpenFence())
        assert hub.has_room
        hub.choose(lane, BIG)
        for _ in range(100):
            await _next(camera, lane)
        assert hub.has_room is has_room
        hub.choose(lane, None)
        assert hub.has_room
    finally:
        hub.stop()


@pytest.mark.parametrize("asked", [True, False])
async def test_encoders_that_hang_are_left_behind_together(*, asked: bool) -> None:
    """Stop takes at most 1.5 s though all encoders hang; a request for it takes no time."""
    encoding, go_on = threading.Semaphore(0), threading.Event()

    class Stuck:
        def __init__(self, _: RenditionSettings) -> None:
            encoding.release()
            go_on.wait(5)

        def encode(self, picture: Picture, *, keyframe: bool) -> EncodedPicture | None:
            return None

    hub = VideoHub(settings=SETTINGS, clock=SystemClock(), make_encoder=Stuck)
    hub.start()
    for name in (BIG, SMALL):
        hub.choose(hub.add(OpenFence()), name)
        assert await asyncio.to_thread(encoding.acquire, timeout=5)
    started_s = monotonic()
    if asked:
        hub.request_stop()
        assert monotonic() - started_s < 0.5
        go_on.set()
        hub.stop()
        assert not [thread for thread in threading.enumerate() if "encode" in thread.name]
    else:
        hub.stop()
        assert 1.4 < monotonic() - started_s < 2.5
        hub.stop()
        go_on.set()


async def test_a_keyframe_for_whoever_drives_is_not_put_off(
    hub: VideoHub, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The operator's keyframe is not delayed by other viewers' requests."""
    asked: list[bool] = []
    rendition = hub._renditions[BIG]
    monkeypatch.setattr(rendition, "request_keyframe", lambda *, is_urgent: asked.append(is_urgent))
    watches, drives = hub.add(OpenFence()), hub.add(OpenFence())
    hub.prioritise(drives)
    for lane in (watches, drives):
        hub.choose(lane, BIG)
    hub.remove(drives)
    hub.request_keyframe(watches)
    assert asked == [False, True, False]
