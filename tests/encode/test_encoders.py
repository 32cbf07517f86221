"""The video encoders: droppable layers, and keyframes on request."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Literal

import av
import cv2
import numpy as np
import pytest
from av.packet import Packet
from av.video.reformatter import ColorRange, Colorspace
from hypothesis import example, given
from hypothesis import strategies as st
from tests.encode.decoders import decoded_pictures
from tests.encode.encoders import GOOD, ODD
from tests.examples import at_length, examples

from wax.capture.letterbox import black, planes
from wax.capture.source import Picture
from wax.config.video import RenditionSettings
from wax.encode.hardware import HardwareEncoder
from wax.encode.video_encoder import (
    IntraEncoder,
    PictureEncoder,
    VideoEncoder,
    frame_of,
    resize_i420,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.encode.encoded import EncodedPicture

SMALL = RenditionSettings(width=160, height=120, fps=30, bitrate_bps=200_000)
THIN = RenditionSettings(width=160, height=120, fps=10, bitrate_bps=16_000)
"""A rendition so small that its motion search is thorough."""
RENDITIONS = {"small": SMALL, "thin": THIN}
CODECS: list[Literal["vp8", "h264"]] = ["vp8", "h264"]


def _encode(
    codec: Literal["vp8", "h264"],
    count: int,
    keyframes: set[int],
    rendition: RenditionSettings = SMALL,
    pause_s: float = 0.0,
) -> list[EncodedPicture]:
    """Encode so many pictures; each keyframe follows the picture before it after a pause."""
    encoder = VideoEncoder(codec=codec, rendition=rendition, now_s=lambda: 0.0)
    texture = np.random.default_rng(1).integers(0, 255, (180, 160 + count), dtype=np.uint8)
    paused_s = [pause_s * sum(one <= i for one in keyframes) for i in range(count)]
    found = [
        encoder.encode(
            Picture(
                np.ascontiguousarray(texture[:, i : i + 160]),
                5000 + i / rendition.fps + paused_s[i],
            ),
            keyframe=i in keyframes,
        )
        for i in range(count)
    ]
    return [one for one in found if one is not None]


@cache
def _layered(rendition: str) -> list[EncodedPicture]:
    return _encode("vp8", 60, {22}, RENDITIONS[rendition])


def _is_keyframe(codec: str, data: bytes) -> bool:
    if codec == "vp8":
        return not data[0] & 1  # RFC 6386, 9.1
    return any(data[i : i + 3] == b"\0\0\1" and data[i + 3] & 31 == 5 for i in range(len(data) - 3))


def test_a_browser_is_told_the_colours() -> None:
    """Each stream declares BT.601 in limited range, or browsers would assume BT.709 for H.264."""
    grey = Picture(np.full((180, 160), 128, np.uint8), 5000.0)
    makers: dict[str, PictureEncoder] = {
        "vp8": VideoEncoder(codec="vp8", rendition=SMALL),
        "h264": VideoEncoder(codec="h264", rendition=SMALL),
        "hardware": HardwareEncoder(GOOD, SMALL),
    }
    for name, encoder in makers.items():
        encoded = encoder.encode(grey, keyframe=True)
        assert encoded is not None
        decoder = av.CodecContext.create("vp8" if name == "vp8" else "h264", "r")
        assert isinstance(decoder, av.VideoCodecContext)
        (frame,) = decoder.decode(Packet(encoded.data))
        assert (name, frame.color_range, frame.colorspace) == (
            name,
            ColorRange.MPEG,
            Colorspace.ITU601,
        )


@pytest.mark.parametrize("codec", CODECS)
def test_keyframes_come_when_asked_and_at_no_other_time(codec: Literal["vp8", "h264"]) -> None:
    """The stream has a keyframe first and on request only, and the label says so."""
    found = _encode(codec, 60, {13, 40})
    assert len(found) == 60
    real = [i for i, one in enumerate(found) if _is_keyframe(codec, one.data)]
    assert real == [0, 13, 40]
    assert [i for i, one in enumerate(found) if one.keyframe] == real


@pytest.mark.parametrize("rendition", RENDITIONS)
@pytest.mark.parametrize("top", [0, 1])
def test_upper_layers_can_be_dropped(top: int, rendition: str) -> None:
    """Without its upper layers a VP8 stream decodes to identical pictures."""
    found = _layered(rendition)
    whole = decoded_pictures(found)
    lower = decoded_pictures([one for one in found if one.layer <= top])
    assert len(lower) == pytest.approx(60 / (4 if top == 0 else 2), abs=2)
    assert all(whole[when] == picture for when, picture in lower.items())


@pytest.mark.parametrize("rendition", RENDITIONS)
@pytest.mark.parametrize("seed", [1, *at_length(2, 3)])
def test_what_is_droppable_is_missed_by_none(seed: int, rendition: str) -> None:
    """Whichever droppable pictures are lost, all others decode identically."""
    found = _layered(rendition)
    luck = np.random.default_rng(seed).random(len(found))
    lost = [one for one, dice in zip(found, luck, strict=True) if one.droppable and dice < 0.5]
    arrived = [one for one in found if one not in lost]
    assert len(lost) > 8
    whole, seen = decoded_pictures(found), decoded_pictures(arrived)
    assert len(seen) == len(arrived)
    assert all(whole[when] == picture for when, picture in seen.items())


@pytest.mark.parametrize("rendition", RENDITIONS)
def test_sync_pictures_need_layer_0_alone(rendition: str) -> None:
    """Without layer 1 the sync pictures decode identically, and the others do not."""
    found = _layered(rendition)
    whole = decoded_pictures(found)
    base = [one for one in found if one.layer != 1]
    for with_sync, is_same in ((True, True), (False, False)):
        arrived = [one for one in base if one.layer == 0 or one.sync is with_sync]
        seen = decoded_pictures(arrived)
        upper = {one.captured_s for one in arrived if one.layer == 2}
        assert len(upper) >= 13
        assert {seen[when] == whole[when] for when in upper} == {is_same}
    assert all(one.sync for one in found if one.layer == 1)


def test_the_layers_start_anew_at_a_keyframe() -> None:
    """A forced keyframe restarts the layer pattern, as in libvpx."""
    assert [one.layer for one in _encode("vp8", 10, {6})] == [0, 2, 1, 2, 0, 2, 0, 2, 1, 2]


def test_a_picture_that_is_not_newer_is_left_out() -> None:
    """A picture that is not newer than the last is skipped."""
    encoder = VideoEncoder(codec="vp8", rendition=SMALL)
    picture = Picture(np.zeros((180, 160), np.uint8), 7.0)
    assert encoder.encode(picture, keyframe=False) is not None
    assert encoder.encode(picture, keyframe=False) is None


@pytest.mark.parametrize("codec", CODECS)
def test_a_keyframe_after_a_pause_is_no_larger(codec: Literal["vp8", "h264"]) -> None:
    """Its interval would have the bits of many pictures, which take seconds on a slow link."""
    without, after = (
        len(_encode(codec, 31, {30}, pause_s=pause_s)[30].data) for pause_s in (0.0, 1.0)
    )
    assert after < 1.2 * without


@pytest.mark.parametrize("codec", CODECS)
def test_the_rate_is_kept(codec: Literal["vp8", "h264"]) -> None:
    """Four seconds of a busy moving picture stay within a quarter of the target."""
    encoder = VideoEncoder(codec=codec, rendition=SMALL, now_s=lambda: 0.0)
    texture = np.random.default_rng(2).integers(0, 255, (180, 640), dtype=np.uint8)
    texture = np.asarray(cv2.GaussianBlur(texture, (0, 0), 1.5), dtype=np.uint8)
    size = 0
    for i in range(120):
        i420 = np.ascontiguousarray(texture[:, i * 4 : i * 4 + 160])
        one = encoder.encode(Picture(i420, 1 + i / 30), keyframe=False)
        assert one is not None
        size += len(one.data)
    assert size * 8 / 4 == pytest.approx(SMALL.bitrate_bps, rel=0.25)


@pytest.mark.parametrize(
    ("grain", "step"),
    [(1.0, 3), *at_length((2.0, 3), (4.0, 12), (8.0, 3))],
)
def test_a_thin_rate_is_kept(grain: float, step: int) -> None:
    """15 s of moving pictures at a modem's rate, fine or coarse, stay within 15 % of the target."""
    encoder = VideoEncoder(codec="vp8", rendition=THIN, now_s=lambda: 0.0)
    noise = np.random.default_rng(3).normal(size=(320, 2000)).astype(np.float32)
    texture = np.asarray(cv2.GaussianBlur(noise, (0, 0), grain))
    texture = np.clip(texture / texture.std() * 50 + 128, 0, 255).astype(np.uint8)[100:220]
    grey = np.full((60, 160), 128, dtype=np.uint8)
    size = 0
    for i in range(150):
        i420 = np.concatenate([texture[:, i * step : i * step + 160], grey])
        one = encoder.encode(Picture(i420, 1 + i / 10), keyframe=i == 100)
        assert one is not None
        size += len(one.data)
    assert size * 8 / 15 == pytest.approx(THIN.bitrate_bps, rel=0.15)


@pytest.mark.parametrize(
    ("width", "height", "fps", "bitrate_bps", "level"),
    [
        (640, 480, 30, 1_000_000, 31),
        (1280, 720, 30, 2_000_000, 31),
        (1280, 720, 60, 2_000_000, 32),
        (1920, 1080, 30, 4_000_000, 40),
        (640, 480, 30, 20_000_000, 32),
        (3840, 64, 5, 1_000_000, 40),
    ],
)
def test_h264_is_constrained_baseline_at_a_true_level(
    width: int, height: int, fps: float, bitrate_bps: int, level: int
) -> None:
    """The parameter set has profile 66, constraint 1, and level 3.1 or what the size needs."""
    rendition = RenditionSettings(width=width, height=height, fps=fps, bitrate_bps=bitrate_bps)
    grey = Picture(np.full((height * 3 // 2, width), 128, np.uint8), 1.0)
    found = VideoEncoder(codec="h264", rendition=rendition).encode(grey, keyframe=True)
    assert found is not None
    data = found.data
    profile_idc, constraints, level_idc = data.split(b"\0\0\1\x67", 1)[1][:3]
    assert profile_idc == 66
    assert constraints & 0x40
    assert level_idc == level


def test_resize_keeps_each_plane() -> None:
    """Scaling keeps the planes apart."""
    i420 = np.concatenate(
        [np.full((120, 160), 200), np.full((30, 160), 90), np.full((30, 160), 30)]
    ).astype(np.uint8)
    small = resize_i420(i420, 64, 48)
    assert small.shape == (72, 64)
    assert (small[:48] == 200).all()
    assert (small[48:60] == 90).all()
    assert (small[60:] == 30).all()
    assert resize_i420(i420, 160, 120) is i420


@pytest.mark.parametrize(("width", "height"), [(320, 180), (160, 90), (60, 34), (640, 90)])
def test_a_much_smaller_picture_has_the_mean_of_all_pixels(width: int, height: int) -> None:
    """However it is scaled, each pixel weighs the same: a checkerboard becomes grey."""
    i420 = (np.indices((1080, 1280)).sum(axis=0) % 2 * 200).astype(np.uint8)
    small = resize_i420(i420, width, height)
    assert small.shape == (height * 3 // 2, width)
    assert np.abs(small.astype(int) - 100).max() <= 8


@pytest.mark.parametrize("height", [32, 34])
def test_no_picture_is_copied_for_its_encoder(height: int) -> None:
    """A frame refers to the picture's own array where PyAV can, and is the same where it cannot."""
    picture = Picture(np.arange(height * 48, dtype=np.uint8).reshape(height * 3 // 2, 32), 1.0)
    rendition = RenditionSettings(width=32, height=height, fps=30, bitrate_bps=400_000)
    frame = frame_of(picture, rendition)
    assert np.array_equal(frame.to_ndarray(), picture.i420)
    picture.i420[0, 0] += 1
    assert (frame.to_ndarray()[0, 0] == picture.i420[0, 0]) == (height % 4 == 0)


EVEN = st.integers(16, 100).map(lambda half: 2 * half)
SIZES = st.tuples(EVEN, EVEN)
PLANES = (200, 90, 40)


@pytest.mark.parametrize("kind", ["vp8", "h264", "hardware", "hardware nv12", "thesis"])
@examples(300)
@given(taken=SIZES, sent=SIZES)
@example(taken=(64, 48), sent=(160, 90))
@example(taken=(160, 90), sent=(64, 48))
@example(taken=(166, 130), sent=(166, 130))
@example(taken=(480, 270), sent=(270, 480))
@example(taken=(3840, 32), sent=(32, 2160))
def test_every_even_size_is_sent(kind: str, taken: tuple[int, int], sent: tuple[int, int]) -> None:
    """A picture of any even size decodes to its rendition's size with its colours."""
    rendition = SMALL.model_copy(update={"width": sent[0], "height": sent[1]})
    i420 = black(*taken)
    for plane, value in zip(planes(i420), PLANES, strict=True):
        plane[:] = value
    encoded = _maker(kind, rendition).encode(Picture(i420, 5000.0), keyframe=True)
    assert encoded is not None
    decoder = av.CodecContext.create("vp8" if kind in {"vp8", "thesis"} else "h264", "r")
    assert isinstance(decoder, av.VideoCodecContext)
    (frame,) = decoder.decode(Packet(encoded.data)) or decoder.decode(None)
    assert (frame.width, frame.height) == sent
    seen = planes(np.asarray(frame.to_ndarray(format="yuv420p"), np.uint8))
    for plane, value in zip(seen, PLANES, strict=True):
        assert np.abs(plane.astype(int) - value).max() < 20


def _maker(kind: str, rendition: RenditionSettings) -> PictureEncoder:
    makers: dict[str, Callable[[], PictureEncoder]] = {
        "vp8": lambda: VideoEncoder(codec="vp8", rendition=rendition),
        "h264": lambda: VideoEncoder(codec="h264", rendition=rendition),
        "hardware": lambda: HardwareEncoder(GOOD, rendition),
        "hardware nv12": lambda: HardwareEncoder(ODD, rendition),
        "thesis": lambda: IntraEncoder(rendition),
    }
    return makers[kind]()
