"""The dialect `frames`, byte by byte."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.robot.serial import frames
from wax.robot.serial.frames import Axis, Decoder, Drive, Frame, Hello, Report, Stop, encode

VECTORS: dict[str, Any] = json.loads(
    (Path(__file__).parent / "vectors" / "frames.json").read_text(encoding="utf-8")
)
VALID = [pytest.param(vector, id=vector["name"]) for vector in VECTORS["valid"]]
IGNORED = [pytest.param(vector, id=vector["name"]) for vector in VECTORS["ignored"]]
STOP = encode(Frame(Stop(), sequence=7, turn=3))

int16, int32 = st.integers(-(2**15), 2**15 - 1), st.integers(-(2**31), 2**31 - 1)
uint8, uint16, uint32 = (st.integers(0, 2**bits - 1) for bits in (8, 16, 32))
bodies = st.one_of(
    st.just(Hello()),
    st.just(Stop()),
    st.builds(Drive, int16, int16),
    st.builds(Axis, uint8, int16),
    st.builds(Report, uint16, uint8, int32, int32, uint8, uint16),
)
any_frame = st.builds(Frame, bodies, sequence=uint16, turn=uint32, ttl_ms=uint16)
noise = st.binary(max_size=60)
nasty = st.lists(st.sampled_from([b"\xa5", b"\x5a", b"\xa5\x5a", b"\x00", STOP[:9], b"\xff"]))


def of(vector: dict[str, Any]) -> Frame:
    return Frame(
        getattr(frames, vector["type"])(**vector["fields"]),
        sequence=vector["sequence"],
        turn=vector["turn"],
        ttl_ms=vector["ttl_ms"],
    )


@pytest.mark.parametrize("vector", VALID)
def test_each_frame_has_exactly_these_bytes(vector: dict[str, Any]) -> None:
    """The wire vectors, written by other code, are what is sent and what is understood."""
    wire = bytes.fromhex(vector["hex"])
    assert encode(of(vector)) == wire
    assert Decoder().feed(wire) == [of(vector)]


@pytest.mark.parametrize("vector", IGNORED)
def test_what_is_no_frame_of_ours_is_ignored_and_counted(vector: dict[str, Any]) -> None:
    """A damaged or unknown frame gives nothing but a count, and the next one is understood."""
    decoder = Decoder()
    found = decoder.feed(bytes.fromhex(vector["hex"]) + STOP)
    assert found == [Frame(Stop(), sequence=7, turn=3)]
    assert decoder.errors >= 1


@given(st.lists(any_frame, max_size=8), st.integers(1, 50))
def test_any_frames_survive_any_cutting(sent: list[Frame], piece: int) -> None:
    """Whatever is sent is understood in order, in pieces of any size, without an error."""
    wire = b"".join(encode(frame) for frame in sent)
    decoder = Decoder()
    found = [f for at in range(0, len(wire), piece) for f in decoder.feed(wire[at : at + piece])]
    assert found == sent
    assert (decoder.errors, decoder.skipped_bytes) == (0, 0)


@given(st.lists(st.one_of(noise, nasty.map(b"".join)), max_size=6), st.integers(1, 30))
def test_after_any_garbage_frames_are_found_again(garbage: list[bytes], piece: int) -> None:
    """No bytes raise; at most one longest frame later the stream is understood again."""
    decoder = Decoder()
    wire = b"".join(garbage) + STOP * 6
    found = [f for at in range(0, len(wire), piece) for f in decoder.feed(wire[at : at + piece])]
    assert found[-1:] == [Frame(Stop(), sequence=7, turn=3)]


@given(any_frame, st.data())
def test_a_flipped_bit_is_never_believed(frame: Frame, data: st.DataObject) -> None:
    """One flipped bit anywhere in a frame never gives another frame."""
    wire = bytearray(encode(frame))
    bit = data.draw(st.integers(0, len(wire) * 8 - 1))
    wire[bit // 8] ^= 1 << bit % 8
    assert Decoder().feed(bytes(wire)) == []


def test_memory_is_bounded() -> None:
    """A megabyte of starts without an end leaves less than a frame in memory."""
    decoder = Decoder()
    for _ in range(256):
        decoder.feed(b"\xa5\x5a\x20" * 1365)
        assert len(decoder._rest) < 64


def test_what_does_not_fit_its_field() -> None:
    """Counters keep their lowest bits, so that they may wrap."""
    wire = encode(Frame(Stop(), sequence=65_536 + 5, turn=2**32 + 6))
    assert Decoder().feed(wire) == [Frame(Stop(), sequence=5, turn=6)]


def test_flags_have_names() -> None:
    """The first flag of a report means moving, the second that a time-to-live ran out."""
    flags = [Report(0, 0, 0, 0, flags, 0) for flags in (0, 1, 2, 3)]
    assert [report.moving for report in flags] == [False, True, False, True]
    assert [report.timed_out for report in flags] == [False, False, True, True]
