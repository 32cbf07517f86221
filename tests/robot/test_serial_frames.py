"""The dialect `frames`, byte by byte."""

from __future__ import annotations

import binascii
import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.examples import at_length

from wax.robot.serial import frames
from wax.robot.serial.frames import (
    NO_SESSION,
    AxisBody,
    Decoder,
    DriveBody,
    Frame,
    HelloBody,
    MoveBody,
    ReportBody,
    StopBody,
    encode,
)

VECTORS: dict[str, Any] = json.loads(
    (Path(__file__).parent / "vectors" / "frames.json").read_text(encoding="utf-8")
)
VALID = [pytest.param(vector, id=vector["name"]) for vector in VECTORS["valid"]]
IGNORED = [pytest.param(vector, id=vector["name"]) for vector in VECTORS["ignored"]]
SESSION = VECTORS["session"]
STOP = encode(Frame(StopBody(), sequence=7, turn=3), SESSION)

int16, int32 = st.integers(-(2**15), 2**15 - 1), st.integers(-(2**31), 2**31 - 1)
uint8, uint16, uint32 = (st.integers(0, 2**bits - 1) for bits in (8, 16, 32))
sessions = st.integers(1, 65_534)
bodies = st.one_of(
    st.builds(HelloBody, sessions),
    st.just(StopBody()),
    st.builds(DriveBody, int16, int16),
    st.builds(MoveBody, int16, int16, int16),
    st.builds(AxisBody, uint8, int16),
    st.builds(ReportBody, uint16, uint8, int32, int32, uint8, uint16, uint16, uint16),
)
any_frame = st.builds(Frame, bodies, sequence=uint16, turn=uint32, ttl_ms=uint16, time_ms=uint32)
noise = st.binary(max_size=60)
nasty = st.lists(st.sampled_from([b"\xa5", b"\x5a", b"\xa5\x5a", b"\x00", STOP[:9], b"\xff"]))


def of(vector: dict[str, Any]) -> Frame:
    return Frame(
        getattr(frames, vector["type"] + "Body")(**vector["fields"]),
        sequence=vector["sequence"],
        turn=vector["turn"],
        ttl_ms=vector["ttl_ms"],
        time_ms=vector["time_ms"],
    )


@pytest.mark.parametrize("vector", VALID)
def test_each_frame_has_exactly_these_bytes(vector: dict[str, Any]) -> None:
    """Encoding and decoding match the wire vectors, which other code has written."""
    wire = bytes.fromhex(vector["hex"])
    assert encode(of(vector), vector["session"]) == wire
    assert Decoder(vector["session"]).feed(wire) == [of(vector)]


@pytest.mark.parametrize("vector", IGNORED)
def test_an_invalid_frame_is_ignored_and_counted(vector: dict[str, Any]) -> None:
    """A damaged or unknown frame is only counted, and the next one is decoded."""
    decoder = Decoder(SESSION)
    found = decoder.feed(bytes.fromhex(vector["hex"]) + STOP)
    assert found == [Frame(StopBody(), sequence=7, turn=3)]
    assert decoder.errors >= 1


@given(st.lists(any_frame, max_size=8), st.integers(1, 50))
def test_any_frames_survive_any_cutting(sent: list[Frame], piece: int) -> None:
    """Frames in pieces of any size are decoded in order and without an error."""
    wire = b"".join(encode(frame, SESSION) for frame in sent)
    decoder = Decoder(SESSION)
    found = [f for at in range(0, len(wire), piece) for f in decoder.feed(wire[at : at + piece])]
    assert found == sent
    assert decoder.errors == 0


@given(st.lists(st.one_of(noise, nasty.map(b"".join)), max_size=6), st.integers(1, 30))
def test_after_any_garbage_frames_are_found_again(garbage: list[bytes], piece: int) -> None:
    """No bytes raise; after at most one longest frame the stream is decoded again."""
    decoder = Decoder(SESSION)
    wire = b"".join(garbage) + STOP * 6
    found = [f for at in range(0, len(wire), piece) for f in decoder.feed(wire[at : at + piece])]
    assert found[-1:] == [Frame(StopBody(), sequence=7, turn=3)]


@given(any_frame, st.data())
def test_flipped_bits_are_never_accepted(frame: Frame, data: st.DataObject) -> None:
    """One to three flipped bits anywhere in a frame never give another frame."""
    wire = bytearray(encode(frame, SESSION))
    for bit in data.draw(st.sets(st.integers(0, len(wire) * 8 - 1), min_size=1, max_size=3)):
        wire[bit // 8] ^= 1 << bit % 8
    assert Decoder(SESSION).feed(bytes(wire)) == []


@pytest.mark.parametrize("behind", [12, *at_length(0, 4)])
def test_a_burst_is_never_accepted(behind: int) -> None:
    """Any change within 16 bits in a row is detected, even where the CRC begins."""
    wire = int.from_bytes(STOP, "big")
    for burst in range(1, 2**16):
        damaged = wire ^ burst << behind
        assert Decoder(SESSION).feed(damaged.to_bytes(len(STOP), "big")) == []


@given(any_frame, sessions, sessions)
def test_another_session_is_never_accepted(frame: Frame, one: int, other: int) -> None:
    """Any frame but hello is decoded only in its own session."""
    wire = encode(frame, one)
    told = isinstance(frame.body, HelloBody)
    assert Decoder(one).feed(wire) == [frame]
    assert Decoder(other).feed(wire) == ([frame] if told or one == other else [])
    assert Decoder(NO_SESSION).feed(wire) == ([frame] if told else [])


@given(st.lists(st.tuples(sessions, st.lists(any_frame, max_size=3)), max_size=4))
def test_the_robots_end_follows_hello(sent: list[tuple[int, list[Frame]]]) -> None:
    """Without a given session, the last hello's applies to the frames after it."""
    wire, wanted = b"", []
    for session, frames_of_it in sent:
        hello = Frame(HelloBody(session))
        others = [frame for frame in frames_of_it if not isinstance(frame.body, HelloBody)]
        wire += encode(hello, 5) + b"".join(encode(frame, session) for frame in others)
        wanted += [hello, *others]
    assert Decoder().feed(encode(Frame(StopBody()), 5) + wire) == wanted


def test_memory_is_bounded() -> None:
    """100 kB of frames without an end leave less than a frame in memory."""
    decoder = Decoder(SESSION)
    for _ in range(25):
        decoder.feed(b"\xa5\x5a\x20" * 1365)
        assert len(decoder._rest) < 64


def test_counters_wrap() -> None:
    """A counter that is too large for its field keeps the lowest bits."""
    frame = Frame(StopBody(), sequence=65_536 + 5, turn=2**32 + 6, time_ms=2**32 + 7)
    wire = encode(frame, SESSION)
    assert Decoder(SESSION).feed(wire) == [Frame(StopBody(), sequence=5, turn=6, time_ms=7)]


def test_flags_have_names() -> None:
    """A report's flags mean moving, an expired time-to-live, and that it obeys moves."""
    flags = [ReportBody(0, 0, 0, 0, flags, 0) for flags in (0, 1, 2, 3, 4)]
    assert [report.moving for report in flags] == [False, True, False, True, False]
    assert [report.timed_out for report in flags] == [False, False, True, True, False]
    assert [report.moves_sideways for report in flags] == [False, False, False, False, True]


def test_defaults_are_zero() -> None:
    """A frame of which only the body is given has zeros, and so has a report."""
    assert Frame(StopBody()) == Frame(StopBody(), sequence=0, turn=0, ttl_ms=0, time_ms=0)
    bare = ReportBody(1, 2, 3, 4, 5, 6)
    assert (bare.damaged, bare.refused) == (0, 0)


def test_a_frame_that_is_too_long_is_detected_by_its_third_byte() -> None:
    """A payload of 32 bytes is awaited; one of 33 is damaged at once."""
    waiting, damaged = Decoder(SESSION), Decoder(SESSION)
    assert waiting.feed(b"\xa5\x5a\x20") == damaged.feed(b"\xa5\x5a\x21") == []
    assert (waiting.errors, damaged.errors) == (0, 1)


def test_a_frame_behind_an_impossible_length_is_found_at_once() -> None:
    """The decoder does not wait for the next bytes."""
    decoder = Decoder(SESSION)
    assert decoder.feed(b"\xa5\x5a\xff" + STOP) == [Frame(StopBody(), sequence=7, turn=3)]
    assert decoder.errors == 1


def test_a_whole_unknown_frame_is_one_error() -> None:
    """An unknown type counts once, and the next frame is decoded."""
    unknown = bytearray(STOP)
    unknown[3] = 0x7F
    unknown[-2:] = binascii.crc_hqx(bytes(unknown[2:-2]), SESSION).to_bytes(2, "big")
    decoder = Decoder(SESSION)
    assert len(decoder.feed(bytes(unknown) + STOP)) == 1
    assert decoder.errors == 1
