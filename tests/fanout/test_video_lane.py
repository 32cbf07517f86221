"""The lane of pictures: what a viewer gets can be decoded, is new, and is bounded."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.encode.decoders import decoded_pictures
from tests.examples import examples

from wax.capture.source import Picture
from wax.config.video import RenditionSettings
from wax.encode.encoded import EncodedPicture
from wax.encode.video_encoder import VideoEncoder
from wax.fanout.video_lane import VideoLane

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


STREAM = _pictures(90, keyframes={0, 45})
WHOLE = decoded_pictures(STREAM)


def _through(
    lane: VideoLane, taken: list[int], tops: list[int] | None = None
) -> list[EncodedPicture]:
    """Put the stream through a lane, and return what its viewer takes.

    Picture i is put once the lane is cut to the layer `tops[i]`; then the viewer takes up to
    `taken[i]` pictures.
    """
    out = []
    for picture, take, top in zip(STREAM, taken, tops or [2] * len(STREAM), strict=True):
        lane.top_layer = top
        lane.put(picture)
        out += [found for _ in range(take) if (found := lane.pop_next()) is not None]
    return out


TAKEN = st.lists(st.sampled_from([0, 0, 0, 1, 1, 2, 5]), min_size=90, max_size=90)
TOPS = st.lists(st.sampled_from([0, 1, 2, 2]), min_size=90, max_size=90)


@examples(100)
@given(TAKEN, TOPS)
def test_what_a_slow_viewer_gets_decodes_to_the_same_pictures(
    taken: list[int], tops: list[int]
) -> None:
    """However slow a viewer is, each of their pictures is exactly the encoder's."""
    lane = VideoLane()
    lane.choose(SMALL.name)
    out = _through(lane, taken, tops)
    assert [p.pts for p in out] == sorted(p.pts for p in out)
    for captured_s, seen in decoded_pictures(out).items():
        assert seen == WHOLE[captured_s]


@examples(100)
@given(TAKEN, TOPS)
def test_what_depends_on_something_has_it(taken: list[int], tops: list[int]) -> None:
    """The pictures that a picture depends on are sent before it, as the packetiser assumes."""
    lane = VideoLane()
    lane.choose(SMALL.name)
    newest: dict[int, int] = {}
    whole: dict[int, int] = {}
    sent = {id(p) for p in _through(lane, taken, tops)}
    for number, picture in enumerate(STREAM):
        needs = [] if picture.keyframe else [0] if picture.sync else range(picture.layer + 1)
        if id(picture) in sent:
            for layer in needs:
                assert newest.get(layer) == whole.get(layer) or layer == picture.layer > 0
            newest[picture.layer] = number
        whole[picture.layer] = number
        if picture.layer == 0:
            for layers in (newest, whole):
                layers.pop(1, None)
                layers.pop(2, None)


def test_a_viewer_who_takes_nothing_holds_at_most_the_bound() -> None:
    """A viewer who takes nothing costs a bounded queue, and the drops are counted."""
    lane = VideoLane()
    lane.choose(SMALL.name)
    for picture in STREAM:
        lane.put(picture)
        assert len(lane._queue) <= 16
    assert lane.dropped + len(lane._queue) == len(STREAM)


def test_what_waits_for_half_a_second_is_not_sent() -> None:
    """After a long blockage stale pictures are dropped, and newer ones are sent."""
    lane = VideoLane()
    lane.choose(SMALL.name)
    for picture in STREAM[:45]:
        lane.put(picture)
    assert lane.pop_next() is None
    assert lane.is_cut
    lane.put(STREAM[45])
    assert lane.pop_next() is STREAM[45]
    assert not lane.is_cut


def test_upper_layers_go_first() -> None:
    """A viewer who gets every second picture loses only pictures that nothing depends on."""
    lane = VideoLane()
    lane.choose(SMALL.name)
    out = _through(lane, [index % 2 for index in range(90)])
    layers = [picture.layer for picture in out]
    assert layers.count(2) < layers.count(0) + layers.count(1)
    assert lane.dropped > 0
    assert len(out) >= 40


@pytest.mark.parametrize(("top", "share"), [(2, 1.0), (1, 0.5), (0, 0.25)])
def test_a_lane_is_cut_to_its_top_layer(top: int, share: float) -> None:
    """Each dropped layer halves the picture rate; nothing else is lost."""
    lane = VideoLane()
    lane.choose(SMALL.name)
    out = _through(lane, [1] * 90, [top] * 90)
    assert {picture.layer for picture in out} == set(range(top + 1))
    assert len(out) == pytest.approx(90 * share, abs=2)


def test_the_newest_is_sent_when_the_way_is_free() -> None:
    """The newest picture is sent before droppable pictures that are queued."""
    lane = VideoLane()
    lane.choose(SMALL.name)
    lane.put(STREAM[0])
    assert lane.pop_next() is STREAM[0]
    for picture in STREAM[1:4]:  # layers 2, 1, and a 2 that depends on that 1
        lane.put(picture)
    assert [lane.pop_next(), lane.pop_next(), lane.pop_next()] == [STREAM[2], STREAM[3], None]


def test_news_is_told() -> None:
    """The listener is called for each picture that can be taken, and for no other."""
    heard: list[int] = []
    lane = VideoLane()
    lane.set_listener(lambda: heard.append(1))
    lane.put(STREAM[0])
    assert not heard
    lane.choose(SMALL.name)
    lane.put(STREAM[0])
    lane.put(STREAM[1])
    assert len(heard) == 2


def test_nothing_is_sent_before_a_keyframe() -> None:
    """A viewer who joins in the middle gets nothing until the next keyframe."""
    lane = VideoLane()
    lane.choose(SMALL.name)
    for picture in STREAM[10:45]:
        lane.put(picture)
        assert lane.pop_next() is None
    lane.put(STREAM[45])
    assert lane.pop_next() is STREAM[45]


OTHER = EncodedPicture(b"keyframe", STREAM[45].pts, "other", True, 0, 200.0)
OTHER_NEXT = EncodedPicture(b"next", STREAM[46].pts, "other", False, 2, 199.0)


def test_a_change_of_rendition_keeps_the_old_one_until_the_new_ones_keyframe() -> None:
    """The old rendition continues until the new one can be decoded, without a gap."""
    lane = VideoLane()
    lane.choose(SMALL.name)
    lane.put(STREAM[0])
    assert lane.pop_next() is STREAM[0]
    lane.choose("other")
    assert lane.takes(SMALL.name)
    lane.put(STREAM[1])
    lane.put(OTHER_NEXT)
    assert lane.pop_next() is STREAM[1]
    lane.put(OTHER)
    lane.put(STREAM[2])
    assert lane.pop_next() is OTHER
    assert lane.pop_next() is None
    assert not lane.takes(SMALL.name)


def test_no_picture_follows_a_newer_one() -> None:
    """A keyframe whose encoder was slower than the old one's is not taken; its next one is."""
    lane = VideoLane()
    lane.choose(SMALL.name)
    lane.put(STREAM[0])
    lane.put(STREAM[1])
    assert lane.pop_next() is STREAM[0]
    lane.choose("other")
    lane.put(replace(STREAM[0], rendition="other"))
    assert lane.is_waiting
    assert lane.pop_next() is STREAM[1]
    lane.put(OTHER)
    assert lane.pop_next() is OTHER
    assert not lane.is_waiting


def test_the_same_moment_in_another_rendition_has_a_time_of_its_own() -> None:
    """Two renditions of one picture are two pictures to a browser: their RTP times differ."""
    lane = VideoLane()
    lane.choose(SMALL.name)
    lane.put(STREAM[0])
    assert lane.pop_next() is STREAM[0]
    lane.choose("other")
    lane.put(replace(STREAM[0], rendition="other"))
    taken = lane.pop_next()
    assert taken is not None
    assert taken.pts == STREAM[0].pts + 1
    assert taken.data is STREAM[0].data


def test_what_is_given_up_is_not_sent() -> None:
    """After `give_up` the old rendition ends at once, and the new one starts by a keyframe."""
    lane = VideoLane()
    lane.choose(SMALL.name)
    lane.put(STREAM[0])
    lane.choose("other")
    lane.give_up()
    lane.put(STREAM[1])
    assert lane.pop_next() is None
    lane.put(OTHER)
    assert lane.pop_next() is OTHER


def test_no_picture_means_nothing_waits() -> None:
    """A viewer who does not want the picture gets none, not even what was queued."""
    lane = VideoLane()
    lane.choose(SMALL.name)
    lane.put(STREAM[0])
    lane.choose(None)
    lane.put(STREAM[1])
    assert lane.pop_next() is None
    assert not lane.takes(SMALL.name)
