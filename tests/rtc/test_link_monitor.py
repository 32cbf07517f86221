"""A viewer's silence and round trip, measured by pings."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.rtc.link_monitor import LinkMonitor


def test_one_exchange_gives_the_round_trip() -> None:
    """One exchange gives the round trip, without the time for which the page held the pong."""
    link = LinkMonitor(0.0)
    assert link.handle_ping(1, None, None, 10.0) is None
    assert link.one_way_s is None
    trip = link.handle_ping(2, 1, 150.0, 10.250)
    assert trip is not None
    assert abs(trip - 0.1) < 1e-9
    assert link.one_way_s == trip / 2


def test_the_least_of_ten_seconds_counts() -> None:
    """One queued ping does not change the delay, and an old one is forgotten."""
    link = LinkMonitor(0.0)
    link.handle_ping(1, None, None, 1.0)
    link.handle_ping(2, 1, 0.0, 1.02)
    link.handle_ping(3, 2, 0.0, 3.02)
    assert link.one_way_s is not None
    assert abs(link.one_way_s - 0.01) < 1e-9
    link.handle_ping(4, 3, 0.0, 12.02)
    assert abs(link.one_way_s - 1.0) < 1e-9


def test_ten_seconds_are_exact() -> None:
    """A round trip counts until it is exactly ten seconds old."""
    link = LinkMonitor(0.0)
    link.handle_ping(1, None, None, 1.0)
    link.handle_ping(2, 1, 0.0, 2.0)
    link.handle_ping(3, None, None, 12.0)
    assert link.one_way_s == 0.5
    link.handle_ping(4, None, None, 12.5)
    assert link.one_way_s is None


def test_the_newest_round_trip_is_kept_too() -> None:
    """The newest round trip includes queueing, though the delay excludes it."""
    assert LinkMonitor(0.0).newest_s is None
    link = LinkMonitor(0.0)
    link.handle_ping(1, None, None, 1.0)
    link.handle_ping(2, 1, 0.0, 1.5)
    link.handle_ping(3, 2, 0.0, 3.5)
    assert (link.one_way_s, link.newest_s) == (0.25, 2.0)


@pytest.mark.parametrize(
    ("pong", "held_ms"),
    [(1, None), (1, -1.0), (1, math.nan), (7, 0.0), (None, 0.0)],
    ids=["held for unknown", "held for less than nothing", "no number", "never sent", "none"],
)
def test_an_incomplete_exchange_gives_no_round_trip(
    pong: int | None, held_ms: float | None
) -> None:
    """An incomplete exchange gives no round trip, so a page cannot gain time for its commands."""
    link = LinkMonitor(0.0)
    link.handle_ping(1, None, None, 1.0)
    assert link.handle_ping(2, pong, held_ms, 1.5) is None
    assert (link.one_way_s, link.newest_s) == (None, None)


def test_a_page_that_claims_too_much_has_no_delay() -> None:
    """A pong held for longer than the exchange took gives a round trip of zero."""
    link = LinkMonitor(0.0)
    link.handle_ping(1, None, None, 1.0)
    assert link.handle_ping(2, 1, 501.0, 1.5) == 0.0


def test_the_last_64_pongs_are_remembered() -> None:
    """The last 64 pongs are remembered, older ones are forgotten."""
    link = LinkMonitor(0.0)
    for ping in range(65):
        link.handle_ping(ping, None, None, float(ping))
    assert link.handle_ping(65, 0, 0.0, 65.0) is None
    assert link.handle_ping(66, 2, 0.0, 66.0) == 64.0


@given(
    st.lists(
        st.tuples(
            st.integers(0, 9),
            st.none() | st.integers(0, 9),
            st.none() | st.floats(-1e15, 1e15),
            st.floats(0, 5),
        )
    )
)
def test_no_ping_makes_a_negative_delay(
    trace: list[tuple[int, int | None, float | None, float]],
) -> None:
    """Whatever a page claims, the delay is never below zero."""
    link = LinkMonitor(0.0)
    now_s = 0.0
    for ping, pong, held_ms, step_s in trace:
        now_s += step_s
        link.handle_ping(ping, pong, held_ms, now_s)
        assert link.one_way_s is None or link.one_way_s >= 0


def test_silence_is_since_anything_was_heard() -> None:
    """Every message counts as a sign of life, and time never runs backwards."""
    link = LinkMonitor(5.0)
    link.record_arrival(7.0)
    link.record_arrival(6.0)
    assert link.silence_s(9.0) == 2.0
