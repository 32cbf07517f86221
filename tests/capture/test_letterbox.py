"""Fitting: whole, in proportion, centred, and never larger than requested."""

from __future__ import annotations

import av
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples

from wax.capture.letterbox import fit_bgr, fit_frame, inner_size

EVEN = st.integers(16, 200).map(lambda half: 2 * half)


@given(shown=st.tuples(st.integers(2, 4000), st.integers(2, 4000)), width=EVEN, height=EVEN)
def test_inner_size_is_even_and_fits(shown: tuple[int, int], width: int, height: int) -> None:
    """The inner size is even, fits, touches two edges and keeps the proportion to two pixels."""
    inner_width, inner_height = inner_size(*shown, width, height)
    assert inner_width % 2 == inner_height % 2 == 0
    assert 2 <= inner_width <= width
    assert 2 <= inner_height <= height
    assert inner_width == width or inner_height == height
    scale = min(width / shown[0], height / shown[1])
    assert abs(inner_width - max(2, shown[0] * scale)) <= 1.01
    assert abs(inner_height - max(2, shown[1] * scale)) <= 1.01


@given(width=EVEN, height=EVEN, odd=st.tuples(st.integers(16, 300), st.integers(16, 300)))
@examples(40)
def test_the_result_is_a_picture_of_the_wanted_size(
    width: int, height: int, odd: tuple[int, int]
) -> None:
    """Any input becomes centred I420 of exactly the requested size."""
    frame = av.VideoFrame.from_ndarray(np.full((odd[1], odd[0], 3), 255, np.uint8), "rgb24")
    i420 = fit_frame(frame, width, height)
    assert (i420.shape, i420.dtype) == ((height * 3 // 2, width), np.dtype(np.uint8))
    inner = inner_size(*odd, width, height)
    for axis, wanted, whole in ((0, inner[0], width), (1, inner[1], height)):
        lit = np.flatnonzero(i420[:height].max(axis=axis) > 128)
        assert len(lit) == pytest.approx(wanted, abs=1)
        assert abs(lit[0] - (whole - 1 - lit[-1])) <= 1


def test_wide_pixels_are_shown_wide() -> None:
    """A frame whose pixels are twice as wide as high is shown twice as wide."""
    frame = av.VideoFrame.from_ndarray(np.full((100, 100, 3), 255, np.uint8), "rgb24")
    luma = fit_frame(frame, 400, 100, pixel_aspect=2.0)[:100]
    assert (luma.max(axis=0) > 128).sum() == 200
    assert (luma.max(axis=1) > 128).all()


def test_an_image_of_the_right_size_is_not_copied() -> None:
    """An image that already has the requested size is returned without a copy."""
    image = np.zeros((480, 640, 3), np.uint8)
    assert fit_bgr(image, 640, 480) is image
    assert fit_bgr(image, 320, 240).shape == (240, 320, 3)
