"""The fan-out: encoded once, only while wanted, keyframes coalesced, the past for who joins."""

from __future__ import annotations

import asyncio
import threading
from time import monotonic
from typing import TYPE_CHECKING

import numpy as np
import pytest

from wax.clock import SystemClock
from wax.config import AudioSettings, RenditionSettings, VideoSettings
from wax.media.sound_encoder import SoundEncoder
from wax.media.sound_hub import SoundHub
from wax.media.source import Picture, Sound
from wax.media.video_hub import VideoHub

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from wax.media.encoded import EncodedPicture, EncodedSound
    from wax.media.lane import VideoLane

BIG, SMALL = "64x48", "32x32"
SETTINGS = VideoSettings(
    renditions=[
        RenditionSettings(width=64, height=48, fps=30, bitrate_bps=100_000),
        RenditionSettings(width=32, height=32, fps=15, bitrate_bps=50_000),
    ]
)


class Camera:
    """Puts pictures into a hub, 1/30 s of capture time apart, faster than real time."""

    def __init__(self, hub: VideoHub) -> None:
        self._hub = hub
        self._taken_s = 50.0
        self._random = np.random.default_rng(4)

    def picture(self) -> None:
        i420 = self._random.integers(0, 255, (72, 64), dtype=np.uint8)
        self._hub.slot.put(Picture(i420, self._taken_s))
        self._taken_s += 1 / 30


@pytest.fixture
async def hub() -> AsyncIterator[VideoHub]:
    found = VideoHub(settings=SETTINGS, clock=SystemClock())
    found.start()
    yield found
    found.stop()


async def _next(camera: Camera, lane: VideoLane) -> EncodedPicture:
    """Film until the lane has a picture."""
    task = asyncio.ensure_future(lane.get())
    async with asyncio.timeout(5):
        while not task.done():
            camera.picture()
            await asyncio.sleep(0.002)
    return task.result()


async def test_two_viewers_share_one_encoder(hub: VideoHub) -> None:
    """Two lanes of one rendition get the very same packets, encoded once."""
    camera, a, b = Camera(hub), hub.add(), hub.add()
    hub.choose(a, BIG)
    hub.choose(b, BIG)
    pictures = [await _next(camera, a) for _ in range(5)]
    shared = [await b.get() for _ in range(5)]
    assert [one.packet for one in pictures] == [one.packet for one in shared]
    assert pictures[0].keyframe


async def test_what_nobody_wants_is_not_encoded(hub: VideoHub) -> None:
    """Without a viewer pictures pass by; when the last one leaves the encoder rests."""
    camera = Camera(hub)
    for _ in range(10):
        camera.picture()
        await asyncio.sleep(0.002)
    assert (hub.wanted, hub.counts()[BIG]) == ([], 0)
    lane = hub.add()
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


async def test_a_joiner_gets_a_keyframe_and_the_crowd_few(hub: VideoHub) -> None:
    """Whoever joins in the middle can decode at once, yet requests of many become one keyframe."""
    camera, first = Camera(hub), hub.add()
    hub.choose(first, BIG)
    seen = [await _next(camera, first) for _ in range(3)]
    started_s = monotonic()
    second = hub.add()
    hub.choose(second, BIG)
    joined = asyncio.ensure_future(second.get())
    while not joined.done():
        for _ in range(20):
            hub.request_keyframe(first)
        seen.append(await _next(camera, first))
    while monotonic() - started_s < 1.0:
        hub.request_keyframe(first)
        seen.append(await _next(camera, first))
    assert joined.result().keyframe
    assert 2 <= sum(one.keyframe for one in seen) <= 6


async def test_a_slower_rendition_skips_pictures(hub: VideoHub) -> None:
    """A rendition of half the frame rate encodes every second picture, evenly."""
    camera, lane = Camera(hub), hub.add()
    hub.choose(lane, SMALL)
    await _next(camera, lane)
    taken_s = [(await _next(camera, lane)).captured_s for _ in range(20)]
    gaps = np.diff(taken_s)
    assert gaps.mean() >= 2 / 30 - 1e-6


async def test_a_change_of_size_has_no_gap(hub: VideoHub) -> None:
    """Both sizes are encoded until the new one's keyframe is there, then only the new one."""
    camera, lane = Camera(hub), hub.add()
    hub.choose(lane, BIG)
    await _next(camera, lane)
    hub.choose(lane, SMALL)
    assert hub.wanted == [BIG, SMALL]
    renditions = [(await _next(camera, lane)).rendition for _ in range(8)]
    assert renditions[-1] == SMALL
    assert renditions == sorted(renditions, key=[BIG, SMALL].index)
    assert hub.wanted == [SMALL]


async def test_what_was_dropped_stays_counted(hub: VideoHub) -> None:
    """When a slow viewer leaves, once or twice told, what his lane dropped is still in the sum."""
    camera, quick, slow = Camera(hub), hub.add(), hub.add()
    hub.choose(quick, BIG)
    hub.choose(slow, BIG)
    while slow.dropped < 3:
        await _next(camera, quick)
    before = hub.dropped
    assert before >= 3
    hub.remove(slow)
    hub.remove(slow)
    assert hub.dropped == before


@pytest.mark.parametrize("asked", [True, False])
async def test_encoders_that_hang_are_left_behind_together(
    monkeypatch: pytest.MonkeyPatch, *, asked: bool
) -> None:
    """Stop takes at most 1.5 s though all encoders hang; a request for it takes no time."""
    encoding, go_on = threading.Semaphore(0), threading.Event()

    class Stuck:
        def __init__(self, **_: object) -> None:
            encoding.release()
            go_on.wait(5)

    monkeypatch.setattr("wax.media.rendition.VideoEncoder", Stuck)
    hub = VideoHub(settings=SETTINGS, clock=SystemClock())
    hub.start()
    for size in (BIG, SMALL):
        hub.choose(hub.add(), size)
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


def _speak(hub: SoundHub, first: int, count: int) -> None:
    samples = np.zeros(960, np.int16)
    for number in range(first, first + count):
        hub.push(Sound(samples, 10 + number / 50))


async def _heard(hub: SoundHub, mu_ms: int, preroll_ms: float) -> list[int]:
    """Return the media time, in 20 ms blocks, of what a fresh lane begins with."""
    lane = hub.add()
    hub.choose(lane, mu_ms, preroll_ms)
    got = []
    while lane._queue:
        got.append((await lane.get()).pts // 960 - 500)
    return got


@pytest.mark.parametrize("others", [0, 1])
@pytest.mark.parametrize("preroll_ms", [0, 100, 500])
async def test_who_joins_hears_the_past_at_once(others: int, preroll_ms: float) -> None:
    """The pre-roll is exactly as long as asked, whether or not somebody listened before."""
    hub = SoundHub(settings=AudioSettings())
    hub.start()
    for _ in range(others):
        hub.choose(hub.add(), 20, 0)
    _speak(hub, 0, 60)
    await asyncio.sleep(0)
    assert await _heard(hub, 20, preroll_ms) == list(range(60 - int(preroll_ms / 20), 60))


async def test_a_second_joiner_hears_of_the_past_what_is_encoded() -> None:
    """Nothing is encoded twice for whoever comes right after the first and asks for more."""
    hub = SoundHub(settings=AudioSettings())
    hub.start()
    _speak(hub, 0, 60)
    assert await _heard(hub, 20, 40) == [58, 59]
    _speak(hub, 60, 1)
    assert await _heard(hub, 20, 100) == [58, 59, 60]


@pytest.mark.parametrize(
    ("mu_ms", "preroll_ms", "blocks"),
    [
        (20, 0, 0),
        (20, 1, 1),
        (20, 100, 5),
        (20, 500, 25),
        (40, 100, 6),
        (60, 100, 6),
        (60, 500, 27),
    ],
)
async def test_the_first_listener_costs_no_more_than_his_preroll(
    monkeypatch: pytest.MonkeyPatch, mu_ms: int, preroll_ms: float, blocks: int
) -> None:
    """Of the past as many blocks are encoded as the pre-roll has, in whole media units to now."""
    taken = []

    class Counting(SoundEncoder):
        def encode(self, block: Sound) -> EncodedSound | None:
            taken.append(round(block.captured_s * 50) - 500)
            return super().encode(block)

    monkeypatch.setattr("wax.media.sound_hub.SoundEncoder", Counting)
    hub = SoundHub(settings=AudioSettings())
    hub.start()
    _speak(hub, 0, 61)
    heard = await _heard(hub, mu_ms, preroll_ms)
    assert taken == list(range(61 - blocks, 61))
    assert heard == taken[:: mu_ms // 20]


async def test_a_preroll_is_not_longer_than_what_was_captured() -> None:
    """Right after the start the past is what there is of it, in whole media units."""
    hub = SoundHub(settings=AudioSettings())
    hub.start()
    _speak(hub, 0, 4)
    assert await _heard(hub, 60, 500.0) == [1]
    assert await _heard(hub, 20, 500.0) == [0, 1, 2, 3]


async def test_sound_goes_on_where_the_past_ended() -> None:
    """After the pre-roll every packet follows once and in order."""
    hub = SoundHub(settings=AudioSettings())
    hub.start()
    _speak(hub, 0, 30)
    lane = hub.add()
    hub.choose(lane, 20, 60.0)
    _speak(hub, 30, 5)
    await asyncio.sleep(0.01)
    got = [(await lane.get()).pts // 960 - 500 for _ in range(8)]
    assert got == list(range(27, 35))


async def test_media_units_are_encoded_while_wanted() -> None:
    """Each length has its encoder while somebody hears it, and no longer."""
    hub = SoundHub(settings=AudioSettings())
    hub.start()
    a, b = hub.add(), hub.add()
    hub.choose(a, 20, 0)
    hub.choose(b, 60, 0)
    assert hub.wanted == [20, 60]
    _speak(hub, 0, 6)
    assert hub.counts() == {"captured": 6, "encoded": 8}
    hub.choose(b, None, 0)
    hub.remove(a)
    assert hub.wanted == []
    _speak(hub, 6, 6)
    assert hub.counts()["encoded"] == 8


async def test_what_was_dropped_of_the_sound_stays_counted() -> None:
    """When a viewer who takes no sound leaves, what his lane dropped is still in the sum."""
    hub = SoundHub(settings=AudioSettings())
    hub.start()
    lane = hub.add()
    hub.choose(lane, 20, 0)
    _speak(hub, 0, 60)
    await asyncio.sleep(0)
    assert hub.dropped == lane.dropped == 10
    hub.remove(lane)
    hub.remove(lane)
    assert hub.dropped == 10
