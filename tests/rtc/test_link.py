"""The link: silence and the round trip, from pings."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from wax.rtc.link import Link


def test_one_exchange_tells_the_round_trip() -> None:
    """The time that the page held the pong does not count."""
    link = Link(0.0)
    assert link.pinged(1, None, None, 10.0) is None
    assert link.one_way_s is None
    trip = link.pinged(2, 1, 150.0, 10.250)
    assert trip is not None
    assert abs(trip - 0.1) < 1e-9
    assert link.one_way_s == trip / 2


def test_the_least_of_ten_seconds_counts() -> None:
    """One ping that waited in a queue does not change the delay; an old one is forgotten."""
    link = Link(0.0)
    link.pinged(1, None, None, 1.0)
    link.pinged(2, 1, 0.0, 1.02)
    link.pinged(3, 2, 0.0, 3.02)
    assert link.one_way_s is not None
    assert abs(link.one_way_s - 0.01) < 1e-9
    link.pinged(4, 3, 0.0, 12.02)
    assert abs(link.one_way_s - 1.0) < 1e-9


@given(
    st.lists(
        st.tuples(
            st.integers(0, 50),
            st.none() | st.integers(0, 50),
            st.none() | st.floats(-1e15, 1e15),
            st.floats(0, 5),
        )
    )
)
def test_no_ping_makes_a_negative_delay(
    trace: list[tuple[int, int | None, float | None, float]],
) -> None:
    """Whatever a page claims, the delay is never below zero and memory stays bounded."""
    link = Link(0.0)
    now_s = 0.0
    for ping, pong, held_ms, step_s in trace:
        now_s += step_s
        link.pinged(ping, pong, held_ms, now_s)
        assert link.one_way_s is None or link.one_way_s >= 0
        assert len(link._pongs) <= 64


def test_silence_is_since_anything_was_heard() -> None:
    """Every message counts as a sign of life, and time never runs back."""
    link = Link(5.0)
    link.heard(7.0)
    link.heard(6.0)
    assert link.silence_s(9.0) == 2.0
