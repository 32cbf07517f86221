"""Packets are retransmitted as often as it can help, and no more."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from wax.rtc.retransmissions import Retransmissions


def _again(repeats: Retransmissions, number: int, round_trip_s: float | None, now_s: float) -> bool:
    """Retransmit a packet if it is due."""
    due = repeats.is_due(number, round_trip_s, now_s)
    if due:
        repeats.sent(number, now_s)
    return due


def test_no_second_copy_leaves_while_one_is_in_flight() -> None:
    """No second copy is sent within a round trip; after that the first may be lost, too."""
    repeats = Retransmissions()
    assert _again(repeats, 7, 0.5, 10.0)
    assert not _again(repeats, 7, 0.5, 10.49)
    assert _again(repeats, 8, 0.5, 10.49)
    assert _again(repeats, 7, 0.5, 10.5)
    assert not _again(repeats, 7, 0.5, 10.9)


def test_a_refused_copy_stays_due() -> None:
    """A copy that the link had no room for is due at the next request."""
    repeats = Retransmissions()
    assert repeats.is_due(7, 0.5, 10.0)
    assert repeats.is_due(7, 0.5, 10.1)


def test_without_a_round_trip_nothing_is_held_back() -> None:
    """A picture at the start of a connection does not wait for a round trip measurement."""
    repeats = Retransmissions()
    assert _again(repeats, 7, None, 10.0)
    assert _again(repeats, 7, None, 10.1)


@given(
    st.lists(st.tuples(st.integers(0, 400), st.floats(0.001, 0.2)), max_size=600),
    st.floats(0.01, 3),
)
def test_copies_of_a_packet_are_a_round_trip_apart(
    asked: list[tuple[int, float]], round_trip_s: float
) -> None:
    """Copies are a round trip apart, whatever is requested, and however often."""
    repeats, now_s = Retransmissions(), 100.0
    sent: dict[int, float] = {}
    for number, pause_s in asked:
        now_s += pause_s
        if _again(repeats, number, round_trip_s, now_s):
            if number in sent:
                assert now_s - sent[number] >= round_trip_s
            sent[number] = now_s


def test_the_copies_of_a_packet_are_limited() -> None:
    """Endless requests for one packet give five copies, at most one per 20 ms."""
    repeats = Retransmissions()
    sent = [n for n in range(4000) if _again(repeats, 7, 0.0, 10 + n / 4096)]
    assert sent == [0, 82, 164, 246, 328]
    assert _again(repeats, 8, 0.0, 11.0)
    assert _again(repeats, 7, 0.0, 21.0), "after minutes it is another packet's number"


def test_old_retransmissions_are_forgotten() -> None:
    """Of thousands of retransmitted packets the newest are remembered."""
    repeats = Retransmissions()
    for number in range(3000):
        assert _again(repeats, number, 0.5, 10.0)
    assert len(repeats._sent) == 1024
