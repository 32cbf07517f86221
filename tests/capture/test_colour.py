"""Five greys and three primaries become BT.601 in limited range, whatever format they had."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Final

import av
import cv2
import numpy as np
import pytest

from wax.capture.letterbox import fit_frame
from wax.capture.source import Picture

if TYPE_CHECKING:
    from numpy.typing import NDArray

BARS: Final = (
    *((grey, grey, grey) for grey in (0, 64, 128, 192, 255)),
    (255, 0, 0),
    (0, 255, 0),
    (0, 0, 255),
)
WEIGHTS: Final = {601: (0.299, 0.114), 709: (0.2126, 0.0722), 2020: (0.2627, 0.0593)}
"""Kr and Kb of ITU-R BT.601, BT.709 and BT.2020."""
NUMBERS: Final = {601: 6, 709: 1, 2020: 9, None: 2}
"""A matrix as a stream declares it (ITU-T H.273, table 4); 2 says nothing."""
RGB: Final = np.repeat(np.array(BARS, np.uint8), 40, 0)[None].repeat(240, 0)
"""320×240 pixels."""


def coded(matrix: int, *, full: bool) -> NDArray[np.float64]:
    """Return Y, Cb and Cr of each bar, in 8 bits."""
    kr, kb = WEIGHTS[matrix]
    red, green, blue = np.array(BARS).T / 255
    luma = kr * red + (1 - kr - kb) * green + kb * blue
    parts = luma, (blue - luma) / 2 / (1 - kb), (red - luma) / 2 / (1 - kr)
    scales = ((255, 0), (255, 128), (255, 128)) if full else ((219, 16), (224, 128), (224, 128))
    return np.array([part * by + zero for part, (by, zero) in zip(parts, scales, strict=True)]).T


def bars(
    form: str,
    matrix: int,
    *,
    full: bool = False,
    size: tuple[int, int] = (320, 240),
    says: int | None = None,
    says_range: int = 0,
) -> av.VideoFrame:
    """Return the bars in a planar format, declared as by a decoder."""
    frame = av.VideoFrame(*size, form)
    for number, (plane, values) in enumerate(
        zip(frame.planes, coded(matrix, full=full).T, strict=False)
    ):
        scale = 1 << (frame.format.components[number].bits - 8)
        kind = np.dtype(np.uint8 if scale == 1 else ">u2" if form.endswith("be") else "<u2")
        line = np.zeros(plane.line_size // kind.itemsize, kind)
        places = np.arange(plane.width) * len(values) // plane.width
        line[: plane.width] = np.clip(values.round(), 0, 255)[places] * scale
        plane.update(line.tobytes() * plane.height)
    frame.colorspace, frame.color_range = NUMBERS[says], says_range
    return frame


def shown(i420: NDArray[np.uint8]) -> NDArray[np.int64]:
    """Return the bars' colours as a browser shows BT.601 in limited range."""
    height, width = i420.shape[0] * 2 // 3, i420.shape[1]
    chroma = i420[height:].reshape(2, height // 2, width // 2)
    at = np.arange(len(BARS)) * width // len(BARS) + width // len(BARS) // 2
    luma = (i420[height // 2, at] - 16.0) / 219
    blue, red = (chroma[:, height // 4, at // 2] - 128.0) / 224
    rgb = (
        luma + 1.402 * red,
        luma - 1.772 * 0.114 / 0.587 * blue - 1.402 * 0.299 / 0.587 * red,
        luma + 1.772 * blue,
    )
    return np.asarray(np.clip(np.array(rgb).T * 255, 0, 255).round(), np.int64)


HD: Final = (1280, 720)
LIMITED, FULL = 1, 2


@pytest.mark.parametrize(
    "frame",
    [
        pytest.param(bars("yuv420p", 601, says=601, says_range=LIMITED), id="limited"),
        pytest.param(bars("yuv420p", 601, full=True, says=601, says_range=FULL), id="full"),
        pytest.param(bars("yuv420p", 601), id="says nothing, SD"),
        pytest.param(bars("yuv420p", 601, size=(720, 576)), id="says nothing, PAL"),
        pytest.param(bars("yuv420p", 709, size=HD), id="says nothing, HD"),
        pytest.param(bars("yuv420p", 709, size=HD[::-1]), id="says nothing, HD upright"),
        pytest.param(bars("yuv420p", 601, size=HD, says=601), id="HD in BT.601"),
        pytest.param(bars("yuv420p", 709, says=709), id="SD in BT.709"),
        pytest.param(bars("yuv420p", 709, full=True, says=709, says_range=FULL), id="709 full"),
        pytest.param(bars("yuv420p10le", 709, says=709, says_range=LIMITED), id="10 bits"),
        pytest.param(bars("yuv420p10be", 2020, says=2020), id="BT.2020, big-endian"),
        pytest.param(bars("yuv422p", 709, says=709), id="4:2:2"),
        pytest.param(bars("yuv444p", 709, full=True, says=709, says_range=FULL), id="4:4:4"),
        pytest.param(bars("yuvj420p", 601, full=True, size=HD), id="JPEG's form"),
        pytest.param(bars("yuvj422p", 601, full=True, size=(101, 61)), id="JPEG, 4:2:2, odd"),
        pytest.param(av.VideoFrame.from_ndarray(RGB, "rgb24"), id="RGB"),
        pytest.param(av.VideoFrame.from_ndarray(RGB[..., ::-1].copy(), "bgr24"), id="BGR"),
        pytest.param(av.VideoFrame.from_ndarray(RGB, "rgb24").reformat(format="gbrp"), id="GBR"),
    ],
)
def test_what_a_stream_declares_is_honoured(frame: av.VideoFrame) -> None:
    """Colours are right within 4 of 255, by the declared range and matrix, or else the format's."""
    for part in (2, 4):  # as it is, and half as large
        i420 = fit_frame(frame, frame.width // part * 2, frame.height // part * 2)
        assert shown(i420) == pytest.approx(np.array(BARS), abs=4)


@pytest.mark.parametrize(
    ("form", "says", "grey"),
    [
        ("gray", FULL, 16 + 100 * 219 / 255),
        ("gray", 0, 16 + 100 * 219 / 255),
        ("gray", LIMITED, 100),  # monochrome HEVC
        ("gray10le", LIMITED, 100),
        ("gray16le", FULL, 16 + 100 * 219 / 255),
        ("gray16be", FULL, 16 + 100 * 219 / 255),
        ("ya8", FULL, 16 + 100 * 219 / 255),
    ],
)
def test_grey_has_a_range_too(form: str, says: int, grey: float) -> None:
    """A grey picture keeps its range and gets no colour."""
    frame = av.VideoFrame(64, 48, form)
    bits = frame.format.components[0].bits
    kind = np.dtype(np.uint8 if bits == 8 else ">u2" if form.endswith("be") else "<u2")
    value = np.array([100 * 257 if bits == 16 else 100 << (bits - 8)], kind).tobytes()
    value += b"\xff" if form == "ya8" else b""
    plane = frame.planes[0]
    plane.update(value * (plane.buffer_size // len(value)))
    frame.color_range = says
    i420 = fit_frame(frame, 32, 24)
    assert i420[:24].mean() == pytest.approx(grey, abs=1)
    assert np.abs(i420[24:].astype(int) - 128).max() <= 1


@pytest.mark.parametrize(
    ("transfer", "codes"),
    [
        # 0, 20.3, 101.5, 203 and 1000 cd/m² as BT.2100 and BT.2408 have them, in 10 bits.
        (16, [0.0, 0.3583, 0.5096, 0.5807, 0.7518]),
        (18, [0.0, 0.3415, 0.6323, 0.7499, 1.0]),
    ],
)
def test_hdr_has_its_white_where_a_screen_has(transfer: int, codes: list[float]) -> None:
    """A tenth, a half and all of white keep their brightness in SDR, and grey stays grey."""
    frame = av.VideoFrame(320, 240, "yuv420p10le")
    places = np.arange(320) * 5 // 320
    for plane, line in zip(
        frame.planes,
        ((64 + 876 * np.array(codes))[places], np.full(160, 512), np.full(160, 512)),
        strict=True,
    ):
        whole = np.zeros(plane.line_size // 2, "<u2")
        whole[: plane.width] = line.round()
        plane.update(whole.tobytes() * plane.height)
    frame.colorspace, frame.color_range, frame.color_trc = NUMBERS[2020], LIMITED, transfer
    i420 = fit_frame(frame, 320, 240)
    wanted = 255 * np.array([0, 0.1, 0.5, 1, 1]) ** (1 / 2.4)
    assert (i420[120, 32::64] - 16.0) / 219 * 255 == pytest.approx(wanted, abs=4)
    assert np.abs(i420[240:].astype(int) - 128).max() <= 2


@pytest.mark.parametrize("form", ["rgba", "yuva420p", "pal8"])
def test_what_is_transparent_is_black(form: str) -> None:
    """Transparent pixels become black, here a transparent white half."""
    rgba = np.full((48, 64, 4), 255, np.uint8)
    rgba[:, 32:, 3] = 0
    if form == "pal8":
        frame = av.VideoFrame(64, 48, "pal8")
        frame.planes[0].update((bytes(32) + b"\1" * (frame.planes[0].line_size - 32)) * 48)
        frame.planes[1].update(b"\xff\xff\xff\xff\xff\xff\xff\0".ljust(1024, b"\0"))
    else:
        frame = av.VideoFrame.from_ndarray(rgba, "rgba").reformat(format=form)
    luma = fit_frame(frame, 64, 48)[:48]
    assert luma[:, :28].min() >= 234
    assert luma[:, 36:].max() <= 17


@pytest.mark.parametrize("kind", [".jpg", ".png"])
def test_a_still_picture_is_full_range(kind: str) -> None:
    """JPEG and PNG snapshots of network cameras keep black and white."""
    _, data = cv2.imencode(kind, RGB[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 100])
    with av.open(io.BytesIO(data.tobytes()), "r") as file:
        frame = next(file.decode(video=0))
    assert shown(fit_frame(frame, 320, 240)) == pytest.approx(np.array(BARS), abs=4)


def test_opencvs_pictures_are_limited_range() -> None:
    """Pictures from OpenCV and from a ROS robot become limited range, too."""
    picture = Picture.from_bgr(RGB[..., ::-1].copy(), 0.0)
    assert shown(picture.i420) == pytest.approx(np.array(BARS), abs=4)


@pytest.mark.parametrize(("orientation", "corner"), [(1, 0), (3, 3), (6, 1), (8, 2)])
def test_a_jpeg_says_which_side_is_up(orientation: int, corner: int) -> None:
    """A snapshot is rotated as its Exif orientation says (Exif 2.3, 4.6.4 A, 0x0112)."""
    lit = np.zeros((64, 64), np.uint8)
    lit[:32, :32] = 255
    data = cv2.imencode(".jpg", lit)[1].tobytes()
    tag = bytes.fromhex("120103000100") + bytes(2) + bytes([orientation, 0, 0, 0])
    exif = b"Exif\0\0II*\0\x08\0\0\0\x01\0" + tag + bytes(4)
    marked = data[:2] + b"\xff\xe1" + (len(exif) + 2).to_bytes(2, "big") + exif + data[2:]
    with av.open(io.BytesIO(marked), "r") as file:
        luma = fit_frame(next(file.decode(video=0)), 64, 64)[:64]
    assert int(np.argmax(luma[16::32, 16::32])) == corner
