"""The lanes: what a viewer gets can be decoded, is new, and is bounded."""

from __future__ import annotations

import asyncio

import av
import numpy as np
from av.packet import Packet
from hypothesis import given, settings
from hypothesis import strategies as st

from wax.config import RenditionSettings
from wax.media.encoded import EncodedPicture
from wax.media.lane import VideoLane
from wax.media.source import Picture
from wax.media.video_encoder import VideoEncoder

SMALL = RenditionSettings(width=64, height=48, fps=30, bitrate_bps=100_000)


def _pictures(count: int, keyframes: set[int]) -> list[EncodedPicture]:
    encoder = VideoEncoder(codec="vp8", rendition=SMALL)
    texture = np.random.default_rng(3).integers(0, 255, (72, 64 + count), dtype=np.uint8)
    found = []
    for index in range(count):
        i420 = np.ascontiguousarray(texture[:, index : index + 64])
        one = encoder.encode(Picture(i420, 100 + index / 30), keyframe=index in keyframes)
        assert one is not None
        found.append(one)
    return found


def _decode(pictures: list[EncodedPicture]) -> dict[int, bytes]:
    decoder = av.CodecContext.create("vp8", "r")
    assert isinstance(decoder, av.VideoCodecContext)
    found = {}
    for picture in pictures:
        for frame in decoder.decode(Packet(bytes(picture.packet))):
            found[picture.packet.pts or 0] = frame.to_ndarray().tobytes()
    return found


STREAM = _pictures(90, keyframes={0, 45})
WHOLE = _decode(STREAM)


async def _through(lane: VideoLane, taken: list[int]) -> list[EncodedPicture]:
    """Put the stream through a lane whose viewer takes `taken[i]` pictures after each put."""
    out = []
    for picture, take in zip(STREAM, taken, strict=True):
        lane.put(picture)
        for _ in range(take):
            if not lane._queue:
                break
            out.append(await lane.get())
    return out


@settings(max_examples=60, deadline=None)
@given(st.lists(st.sampled_from([0, 0, 0, 1, 1, 2, 5]), min_size=90, max_size=90))
def test_what_a_slow_viewer_gets_decodes_to_the_same_pictures(taken: list[int]) -> None:
    """However slow a viewer is, each picture that he gets is bit for bit the encoder's."""
    lane = VideoLane()
    lane.choose(SMALL.name)
    out = asyncio.run(_through(lane, taken))
    assert [p.packet.pts for p in out] == sorted(p.packet.pts or 0 for p in out)
    for pts, decoded in _decode(out).items():
        assert decoded == WHOLE[pts]


def test_a_viewer_who_takes_nothing_holds_at_most_the_bound() -> None:
    """A viewer who takes nothing costs a bounded queue, and the drops are counted."""
    lane = VideoLane()
    lane.choose(SMALL.name)
    for picture in STREAM:
        lane.put(picture)
        assert len(lane._queue) <= 8
    assert lane.dropped + len(lane._queue) == len(STREAM)


def test_upper_layers_go_first() -> None:
    """A viewer who takes every second picture loses only pictures that nothing depends on."""
    lane = VideoLane()
    lane.choose(SMALL.name)
    out = asyncio.run(_through(lane, [index % 2 for index in range(90)]))
    layers = [picture.layer for picture in out]
    assert layers.count(2) < layers.count(0) + layers.count(1)
    assert lane.dropped > 0
    assert len(out) >= 40


def test_nothing_is_sent_before_a_keyframe() -> None:
    """A viewer who joins in the middle gets nothing until the next keyframe."""
    lane = VideoLane()
    lane.choose(SMALL.name)
    for picture in STREAM[10:46]:
        lane.put(picture)
    assert asyncio.run(lane.get()).keyframe


def test_a_change_of_size_keeps_the_old_one_until_the_new_ones_keyframe() -> None:
    """There is no gap between two sizes: the old one goes on until the new one can be decoded."""
    lane = VideoLane()
    lane.choose(SMALL.name)
    lane.put(STREAM[0])
    lane.choose("other")
    assert lane.takes(SMALL.name)
    lane.put(STREAM[1])
    other = EncodedPicture(STREAM[45].packet, "other", True, 0, 200.0)
    lane.put(EncodedPicture(STREAM[46].packet, "other", False, 2, 199.0))
    lane.put(other)
    lane.put(STREAM[2])
    got = [asyncio.run(lane.get()) for _ in range(3)]
    assert got == [STREAM[0], STREAM[1], other]
    assert not lane._queue
    assert not lane.takes(SMALL.name)


def test_no_picture_means_nothing_waits() -> None:
    """Who does not want the picture gets none, not even what was waiting."""
    lane = VideoLane()
    lane.choose(SMALL.name)
    lane.put(STREAM[0])
    lane.choose(None)
    lane.put(STREAM[1])
    assert not lane._queue
    assert not lane.takes(SMALL.name)


async def test_get_waits() -> None:
    """An empty lane waits instead of turning in circles."""
    task = asyncio.ensure_future(VideoLane().get())
    await asyncio.sleep(0)
    assert not task.done()
    task.cancel()
