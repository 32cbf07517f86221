"""The frames of a hand control."""

from __future__ import annotations

import binascii
import random
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples

from wax.driver.hand import HandReading
from wax.robot.hand.line import ASIDE, ASIDE_LENGTH, LENGTH, RESTART_S, START, HandDecoder, encode

REST = HandReading(5.0)

sticks = st.integers(-100, 100).map(lambda step: step / 100)
readings = st.builds(
    HandReading,
    at_s=st.just(5.0),
    linear=sticks,
    angular=sticks,
    is_held=st.booleans(),
    stop=st.booleans(),
    ask=st.sampled_from([None, "wait", "go_on", "left", "right"]),
    lateral=st.one_of(st.just(0.0), sticks),
)


def test_a_frame_byte_by_byte() -> None:
    """The bytes are as described for people who build a control."""
    reading = HandReading(5.0, linear=1.0, angular=-0.5, is_held=True, ask="left")
    assert encode(reading, 258).hex() == "a55b0264ce11eed7f8"


def planar(reading: HandReading, number: int) -> bytes:
    """Return what a control that can ask for sideways sends."""
    return encode(reading, number, has_aside=True)


def known() -> HandDecoder:
    """Return the decoder of a control that has shown that it cannot."""
    decoder = HandDecoder()
    assert decoder.feed(encode(REST, -1) + encode(REST, 0), -RESTART_S) == [
        replace(REST, at_s=-RESTART_S)
    ]
    return decoder


@given(st.lists(readings, max_size=20), st.integers(1, 7), st.booleans())
def test_readings_survive_encoding(sent: list[HandReading], piece: int, can: bool) -> None:
    """Every reading is decoded, in whatever pieces it arrives."""
    sent = [one if can else replace(one, lateral=0.0) for one in sent]
    encoded = [encode(one, number + 1, has_aside=can) for number, one in enumerate(sent)]
    data = b"".join(encoded)
    decoder = HandDecoder() if can else known()
    found = []
    for at in range(0, len(data), piece):
        found += decoder.feed(data[at : at + piece], 5.0)
    assert found == sent
    assert decoder.errors == 0


@examples(2000)
@given(readings, st.integers(0, 8 * LENGTH - 1), st.integers(0, 8 * LENGTH - 1))
def test_a_damaged_frame_is_dropped(reading: HandReading, one: int, other: int) -> None:
    """One or two flipped bits are always detected, and the next frame is decoded."""
    damaged = bytearray(encode(reading, 1))
    for bit in {one, other}:
        damaged[bit // 8] ^= 1 << bit % 8
    decoder = known()
    assert decoder.feed(bytes(damaged) + encode(REST, 2), 5.0) == [REST]
    assert decoder.errors or min(one, other) < 8 * len(START), "no start is no error"


def test_sideways_comes_before_its_frame() -> None:
    """The bytes of a frame are as without it."""
    reading = HandReading(5.0, linear=1.0, angular=-0.5, is_held=True, ask="left", lateral=-0.4)
    assert planar(reading, 258).hex() == "a55c02d8276af7" + encode(reading, 258).hex()
    decoder = HandDecoder()
    wire = planar(reading, 258)
    assert [one for byte in wire for one in decoder.feed(bytes([byte]), 5.0)] == [reading]


@given(readings, st.integers(0, 8 * ASIDE_LENGTH - 1), st.integers(0, 8 * ASIDE_LENGTH - 1))
def test_damaged_bytes_never_put_the_stick_at_rest(
    reading: HandReading, one: int, other: int
) -> None:
    """Whether sideways is held is not guessed: only the Stop of such a frame counts."""
    wire = bytearray(planar(reading, 2))
    for bit in {one, other}:
        wire[bit // 8] ^= 1 << bit % 8
    for before in (b"", planar(REST, 1)):
        *_, last = [REST, *HandDecoder().feed(before + bytes(wire), 5.0)]
        if reading.stop:
            assert last.stop
            assert not last.is_in_range
        else:
            assert last == REST


def test_sideways_is_sent_twice() -> None:
    """A frame does not count if the stick's inverse is another, though the checksum is right."""
    body = bytes([1, 70, 70])
    wire = ASIDE + body + binascii.crc_hqx(body, 0xFFFF).to_bytes(2, "big") + encode(REST, 1)
    assert HandDecoder().feed(wire, 5.0) == []


@pytest.mark.parametrize("between", [b"\0", encode(REST, 1)[:4], encode(REST, 1)])
def test_sideways_is_of_the_frame_behind_it(between: bytes) -> None:
    """With bytes of another number, or not directly before it, a frame does not count."""
    aside = planar(replace(REST, lateral=1.0), 2)[:ASIDE_LENGTH]
    decoder = HandDecoder()
    decoder.feed(planar(REST, 1), 5.0)
    assert decoder.feed(aside + encode(REST, 3), 5.0) == []
    assert decoder.feed(aside + between + encode(REST, 4), 5.0) == []
    assert decoder.errors >= 2


def test_a_control_shows_by_two_frames_that_it_cannot_move_sideways() -> None:
    """A first frame may be one whose bytes were lost, so it does not count; its Stop does."""
    assert HandDecoder().feed(encode(REST, 1), 5.0) == []
    assert HandDecoder().feed(encode(REST, 1) + encode(REST, 2), 5.0) == [REST]
    (stopped,) = HandDecoder().feed(encode(replace(REST, stop=True), 1), 5.0)
    assert stopped.stop


@given(st.binary(max_size=200))
def test_noise_raises_nothing_and_is_forgotten(noise: bytes) -> None:
    """After any noise, at the latest the third frame is decoded."""
    decoder = HandDecoder()
    decoder.feed(noise, 0.0)
    after = decoder.feed(b"".join(encode(REST, number) for number in (1, 2, 3)), 5.0)
    assert after[-1:] == [REST]


def test_any_buttons_may_be_pressed_together() -> None:
    """A hand on the whole pad presses all six, and a seventh does not exist."""
    for buttons, counts in ((0b11_1111, True), (0b100_0000, False)):
        body = bytes([1, 0, 0, buttons, ~buttons & 0xFF])
        wire = START + body + binascii.crc_hqx(body, 0xFFFF).to_bytes(2, "big")
        assert [one.stop for one in known().feed(wire, 5.0)] == [True] * counts


def test_noise_of_a_million_bytes_is_nearly_never_a_frame() -> None:
    """With a checksum, and buttons sent twice, noise presses none."""
    rng = random.Random(7)
    decoder = HandDecoder()
    assert sum(len(decoder.feed(rng.randbytes(1000), 0.0)) for _ in range(1000)) == 0


@pytest.mark.parametrize(
    ("number", "counts"), [(10, False), (9, False), (11, True), (137, True), (138, False)]
)
def test_only_a_newer_number_counts(number: int, counts: bool) -> None:
    """Repeated or older frames are ignored."""
    decoder = known()
    assert decoder.feed(encode(REST, 10), 5.0) == [REST]
    assert bool(decoder.feed(encode(REST, number), 5.0)) is counts


def test_a_control_that_restarts_may_start_over() -> None:
    """After 1 s without a frame any number is accepted."""
    decoder = known()
    decoder.feed(encode(REST, 200), 5.0)
    assert decoder.feed(encode(REST, 200), 5.0 + RESTART_S - 0.001) == []
    assert len(decoder.feed(encode(REST, 200), 5.0 + RESTART_S)) == 1


def test_a_stick_beyond_its_range_is_read_as_it_is() -> None:
    """The rules must see that it is out of range."""
    (found,) = known().feed(encode(HandReading(5.0, linear=1.27, angular=-1.28), 1), 5.0)
    assert (found.linear, found.angular) == (1.27, -1.28)
    assert not found.is_in_range
