"""Transport-wide feedback as browsers write it is parsed, anything else is refused."""

from __future__ import annotations

from random import Random
from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.rtc.browser_feedback import feedback_packet

from wax.errors import ProtocolError
from wax.rtc.twcc_feedback import PERIOD_S, TICK_S, Feedback, parse

if TYPE_CHECKING:
    from collections.abc import Sequence

CHROMIUM = bytes.fromhex("afcd0005fa17fa1743032fa0009900013de8021720019401")
"""One packet written by Chromium (a sample that several implementations test with)."""

steps = st.one_of(
    st.none(),
    st.integers(0, 255),
    st.integers(-0x8000, -1),
    st.integers(256, 0x7FFF),
)


def ticks_of(start: int, found: Sequence[int | None]) -> list[int | None]:
    """Turn deltas between arrivals into arrival times."""
    at, ticks = start, list[int | None]()
    for step in found:
        at += step or 0
        ticks.append(None if step is None else at)
    return ticks


def whole(feedback: Feedback) -> tuple[float | None, ...]:
    """Return one entry for each packet, None for those that had not arrived."""
    arrived = dict(feedback.arrivals)
    assert list(arrived) == sorted(arrived)
    return tuple(arrived.get(place) for place in range(feedback.packets))


def test_a_sample_by_chromium_is_read() -> None:
    """A known packet's sequence number, reference time and delta are read, its padding ignored."""
    feedback = parse(CHROMIUM)
    assert feedback.sequence_number == 153
    assert whole(feedback) == pytest.approx((4057090 * 0.064 + 148 * TICK_S,), abs=1e-6)


def test_each_kind_of_chunk_is_read() -> None:
    """Run, one-bit and two-bit chunks and a negative delta are read, as the draft has them."""
    packet = bytes.fromhex(
        "8fcd0009 00000001 00000002"
        "fffe 0019 ffffff 07"  # 25 statuses from 65534 on; the reference is 64 ms before zero
        "2002"  # a run of two small deltas
        "a001"  # one bit each: small, 12 lost, small
        "d900"  # two bits each: small, large, small, 4 lost
        "4001"  # a run of one large delta
        "0001"  # a run of one lost
        "04 00 05 06 07 fffc 08 0200"
    )
    ticks = [-252, -252, -247, *([None] * 12), -241]
    ticks += [-234, -238, -230, None, None, None, None, 282, None]
    feedback = parse(packet)
    assert feedback.sequence_number == 65534
    assert whole(feedback) == tuple(None if t is None else t * TICK_S for t in ticks)


@given(
    st.integers(0, 0xFFFF),
    st.integers(-(2**31) + 2**22, 2**31 - 2**22),
    st.lists(steps, min_size=1, max_size=120)
    | st.lists(st.sampled_from([None, 0, 3]), min_size=1, max_size=120),
    st.randoms(use_true_random=False),
)
def test_whatever_a_browser_writes_is_read(
    sequence_number: int, start: int, found: list[int | None], random: Random
) -> None:
    """Any pattern of losses, orders and gaps is read back, whichever chunks encode it."""
    ticks = ticks_of(start, found)
    feedback = parse(feedback_packet(sequence_number, ticks, random))
    assert feedback.sequence_number == sequence_number
    assert whole(feedback) == tuple(None if t is None else t * TICK_S for t in ticks)
    assert all(abs(t) < PERIOD_S for _, t in feedback.arrivals)


def test_runs_of_thousands_are_read() -> None:
    """Feedback after a long outage may span more packets than a single chunk can."""
    ticks = [0, *([None] * 20_000), 77]
    assert whole(parse(feedback_packet(9, ticks, Random(1)))) == tuple(
        None if t is None else t * TICK_S for t in ticks
    )


@given(st.binary(max_size=80))
def test_any_bytes_raise_only_a_protocol_error(data: bytes) -> None:
    """Nothing but `ProtocolError` is raised."""
    with pytest.raises(ProtocolError):
        parse(data)


@given(
    st.lists(steps, min_size=1, max_size=40),
    st.randoms(use_true_random=False),
    st.lists(st.tuples(st.integers(0, 10**6), st.integers(0, 255)), max_size=4),
    st.integers(0, 200),
)
def test_damaged_feedback_is_refused_or_complete(
    found: list[int | None], random: Random, damage: list[tuple[int, int]], cut: int
) -> None:
    """Damaged feedback either parses completely or raises `ProtocolError`."""
    data = bytearray(feedback_packet(1, ticks_of(0, found), random))
    for at, value in damage:
        data[at % len(data)] = value
    if cut < len(data) // 4:
        data = data[: len(data) - 4 * cut]
        data[2:4] = (len(data) // 4 - 1).to_bytes(2, "big")
    try:
        feedback = parse(bytes(data))
    except ProtocolError:
        return
    assert feedback.packets == int.from_bytes(data[14:16], "big") > 0
    assert all(0 <= place < feedback.packets for place, _ in feedback.arrivals)
    assert 0 <= feedback.sequence_number <= 0xFFFF


@pytest.mark.parametrize(
    "packet",
    [
        pytest.param("80c90001 00000001", id="a receiver report"),
        pytest.param("8fce0005" + "00" * 20, id="payload-specific feedback"),
        pytest.param("81cd0005" + "00" * 20, id="a NACK"),
        pytest.param("4fcd0005" + CHROMIUM[4:].hex(), id="version 1"),
        pytest.param("afcd0006" + CHROMIUM[4:].hex(), id="longer than it is"),
        pytest.param(CHROMIUM.hex() + "00000000", id="shorter than it is"),
        pytest.param(CHROMIUM[:-1].hex() + "00", id="padding of zero"),
        pytest.param(CHROMIUM[:-1].hex() + "05", id="more padding than there is"),
        pytest.param(CHROMIUM[:-1].hex() + "02", id="padding over the delta"),
        pytest.param(CHROMIUM.hex().replace("00990001", "00990000"), id="no packet"),
        pytest.param(CHROMIUM.hex().replace("20019401", "60019401"), id="an unknown status"),
        pytest.param(CHROMIUM.hex().replace("20019401", "20009401"), id="a run of none"),
    ],
)
def test_other_packets_are_refused(packet: str) -> None:
    """Each field is checked by itself."""
    with pytest.raises(ProtocolError):
        parse(bytes.fromhex(packet))
