"""A picture of any even size goes through all stages, and is the right way up."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import av
import numpy as np
import pytest
from av.packet import Packet
from hypothesis import example, given
from hypothesis import strategies as st
from tests.encode.quarters import CORNERS, Corners, corners, quartered
from tests.examples import examples

from wax.capture.blanking import Blanking
from wax.capture.letterbox import black, fit_bgr, planes
from wax.capture.source import Picture
from wax.capture.timestamp_overlay import overlay_time
from wax.capture.upright import turned
from wax.config.camera import CameraSettings
from wax.config.video import DrivingViewSettings, RenditionSettings
from wax.encode.video_encoder import VideoEncoder

if TYPE_CHECKING:
    from numpy.typing import NDArray

HALVES = st.integers(16, 60)
CODECS: list[Literal["vp8", "h264"]] = ["vp8", "h264"]


def turned_corners(quarters: int, *, mirror: bool) -> Corners:
    around = np.rot90(np.arange(4).reshape(2, 2), -quarters)
    return [CORNERS[at] for at in (around[:, ::-1] if mirror else around).ravel()]


def decoded(codec: Literal["vp8", "h264"], data: bytes) -> NDArray[np.uint8]:
    decoder = av.CodecContext.create(codec, "r")
    assert isinstance(decoder, av.VideoCodecContext)
    (frame,) = decoder.decode(Packet(data)) or decoder.decode(None)
    return np.asarray(frame.to_ndarray(format="yuv420p"), np.uint8)


@pytest.mark.parametrize("codec", CODECS)
@examples(60)
@given(
    halves=st.tuples(HALVES, HALVES),
    rotate=st.sampled_from([0, 90, 180, 270]),
    mirror=st.booleans(),
)
@example(halves=(427, 240), rotate=90, mirror=True)  # 16:9
@example(halves=(645, 270), rotate=270, mirror=False)  # 21:9
@example(halves=(241, 241), rotate=180, mirror=False)
@example(halves=(1920, 1080), rotate=90, mirror=False)
@example(halves=(1920, 16), rotate=0, mirror=True)
@example(halves=(16, 1080), rotate=180, mirror=True)
def test_each_stage_keeps_the_quarters_where_they_belong(
    codec: Literal["vp8", "h264"],
    halves: tuple[int, int],
    rotate: Literal[0, 90, 180, 270],
    *,
    mirror: bool,
) -> None:
    """A picture is turned, dated and sent in two sizes of its ladder, with its colours."""
    width, height = 2 * halves[0], 2 * halves[1]
    keys = {"source": "0", "width": width, "height": height, "rotate": rotate, "mirror": mirror}
    picture = quartered(width, height)
    upright = Picture(turned(picture.i420, rotate // 90, mirror=mirror), picture.captured_s)
    view = DrivingViewSettings.model_validate(keys)
    beside = CameraSettings.model_validate(keys | {"name": "Arm"})
    assert (upright.width, upright.height) == view.upright_size == beside.upright_size
    upright = overlay_time(upright, 1_795_249_152_112)
    for rendition in (view.renditions[0], beside.renditions[-1]):
        encoder = VideoEncoder(codec=codec, rendition=rich(rendition))
        encoded = encoder.encode(upright, keyframe=True)
        assert encoded is not None
        seen = decoded(codec, encoded.data)
        assert seen.shape == (rendition.height * 3 // 2, rendition.width)
        expected = np.array(turned_corners(rotate // 90, mirror=mirror))
        assert np.abs(np.array(corners(seen)) - expected).max() < 24


def rich(rendition: RenditionSettings) -> RenditionSettings:
    """Return the rendition at a rate that shows the colours, not the rate control."""
    return rendition.model_copy(update={"bitrate_bps": 20_000_000})


@given(st.tuples(HALVES, HALVES))
def test_a_blanked_picture_is_black_in_any_size(halves: tuple[int, int]) -> None:
    """No plane of it holds anything of the camera's."""
    width, height = 2 * halves[0], 2 * halves[1]
    blank = Blanking(lambda: True).picture(quartered(width, height))
    assert blank is not None
    assert (blank.i420 == black(width, height)).all()


@given(st.tuples(HALVES, HALVES), st.tuples(st.integers(9, 200), st.integers(9, 200)))
def test_a_camera_of_any_size_is_fitted_with_its_colours(
    halves: tuple[int, int], given_size: tuple[int, int]
) -> None:
    """What a camera gives instead of the configured size is scaled into it, odd or not."""
    width, height = 2 * halves[0], 2 * halves[1]
    bgr = np.full((given_size[1], given_size[0], 3), (30, 60, 200), np.uint8)
    picture = Picture.from_bgr(fit_bgr(bgr, width, height), 1.0)
    assert (picture.width, picture.height) == (width, height)
    middle = [plane[plane.shape[0] // 2, plane.shape[1] // 2] for plane in planes(picture.i420)]
    assert np.abs(np.array(middle, int) - (97, 95, 186)).max() < 8


def test_what_no_level_allows_is_a_sentence() -> None:
    """4K may stand or lie, but not be larger."""
    keys = {"fps": 30, "bitrate_bps": 9_000_000}
    assert RenditionSettings.model_validate(keys | {"width": 2160, "height": 3840}).height == 3840
    with pytest.raises(ValueError, match=r"2162x3840 is more than H.264's levels allow"):
        RenditionSettings.model_validate(keys | {"width": 2162, "height": 3840})
