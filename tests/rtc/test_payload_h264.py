"""H.264 payloads: the stream is recovered intact, and no payload exceeds its limit."""

from __future__ import annotations

from random import Random

import numpy as np
import pytest
from aiortc.codecs.h264 import H264PayloadDescriptor
from hypothesis import given
from hypothesis import strategies as st

from wax.capture.source import Picture
from wax.config.video import RenditionSettings
from wax.encode.video_encoder import VideoEncoder
from wax.rtc.payload import h264

START = b"\x00\x00\x00\x01"

bodies = st.integers(1, 4000).flatmap(
    lambda size: st.integers(0, 2**32).map(
        lambda seed: Random(seed).randbytes(size).replace(b"\x00", b"\x03")
    )
)
units = st.tuples(st.integers(1, 23), st.integers(0, 3), bodies).map(
    lambda unit: bytes((unit[1] << 5 | unit[0],)) + unit[2]
)
streams = st.lists(
    st.tuples(st.sampled_from([b"\x00\x00\x01", START]), units, st.sampled_from([0, 0, 1, 5])),
    max_size=12,
)


def packets(data: bytes, *, max_bytes: int) -> list[bytes]:
    return [head + piece for head, piece in h264.packets(data, max_bytes=max_bytes)]


def unpacked(payloads: list[bytes]) -> bytes:
    return b"".join(H264PayloadDescriptor.parse(payload)[1] for payload in payloads)


@given(streams, st.integers(32, 1300))
def test_nal_units_are_recovered(stream: list[tuple[bytes, bytes, int]], max_bytes: int) -> None:
    """Any NAL units are recovered by aiortc, after either start code and with trailing zeros."""
    data = b"".join(start + unit + bytes(zeros) for start, unit, zeros in stream)
    payloads = packets(data, max_bytes=max_bytes)
    assert unpacked(payloads) == b"".join(START + unit for _, unit, _ in stream)
    assert all(len(payload) <= max_bytes for payload in payloads)


@given(units, st.integers(32, 1300))
def test_a_large_unit_is_cut_into_parts_of_one_size(unit: bytes, max_bytes: int) -> None:
    """A large unit is split into as few parts as possible; only the first and last are marked."""
    payloads = packets(START + unit, max_bytes=max_bytes)
    if len(unit) <= max_bytes:
        assert payloads == [unit]
        return
    sizes = [len(payload) for payload in payloads]
    assert len(set(sizes[:-1])) == 1
    assert sizes[0] - len(sizes) < sizes[-1] <= sizes[0]
    assert len(sizes) == -(-(len(unit) - 1) // (max_bytes - 2))
    marks = [payload[1] >> 5 for payload in payloads]
    assert marks == [0b100, *([0] * (len(payloads) - 2)), 0b010]
    assert {payload[0] for payload in payloads} == {unit[0] & 0xE0 | 28}
    assert {payload[1] & 31 for payload in payloads} == {unit[0] & 31}


def test_small_units_share_a_packet() -> None:
    """Parameter sets and a small picture share a packet, with the highest importance among them."""
    sets, picture = [b"\x67abc", b"\x68de"], b"\x65" + b"x" * 40
    data = b"".join(START + unit for unit in [*sets, picture])
    assert packets(data, max_bytes=55) == [
        b"\x78" + b"\x00\x04\x67abc" + b"\x00\x03\x68de" + b"\x00\x29" + picture
    ]
    assert packets(data, max_bytes=54) == [
        b"\x78" + b"\x00\x04\x67abc" + b"\x00\x03\x68de",
        picture,
    ]
    assert packets(START + b"\x06m" + START + b"\xa1n", max_bytes=55)[0][0] == 0x80 | 0x20 | 24


def test_a_large_unit_between_small_ones_keeps_its_place() -> None:
    """Small units before a large one leave before it, those after it in a new packet."""
    units = [b"\x67a", b"\x68b", b"\x65" + b"x" * 100, b"\x06c", b"\x06d"]
    payloads = packets(b"".join(START + unit for unit in units), max_bytes=64)
    assert [payload[0] & 31 for payload in payloads] == [24, 28, 28, 24]
    assert unpacked(payloads) == b"".join(START + unit for unit in units)


@pytest.mark.parametrize("data", [b"", b"no start code", b"\x00\x00\x01", START + START])
def test_data_without_units_makes_no_packet(data: bytes) -> None:
    """Data without a NAL unit gives no packet."""
    assert packets(data, max_bytes=100) == []


def test_too_little_room_is_refused() -> None:
    """A limit below 32 bytes, hardly more than the headers, is refused."""
    with pytest.raises(ValueError, match="32 bytes"):
        packets(START + b"\x65abc", max_bytes=31)


@pytest.mark.parametrize("max_bytes", [200, 1200])
def test_real_pictures_arrive(max_bytes: int) -> None:
    """The encoder's own stream is recovered, including the keyframe and its parameter sets."""
    rendition = RenditionSettings(width=160, height=120, fps=30, bitrate_bps=200_000)
    encoder = VideoEncoder(codec="h264", rendition=rendition)
    noise = np.random.default_rng(1).integers(0, 255, (180, 160), dtype=np.uint8)
    for index in range(3):
        encoded = encoder.encode(Picture(noise, 1 + index / 30), keyframe=False)
        assert encoded is not None
        data = encoded.data
        payloads = packets(data, max_bytes=max_bytes)
        assert all(len(payload) <= max_bytes for payload in payloads)
        found = unpacked(payloads).replace(START, START[1:])
        assert found == data.replace(START, START[1:])
        assert (7 in {payload[0] & 31 for payload in payloads} or payloads[0][0] & 31 == 24) is (
            index == 0
        )
