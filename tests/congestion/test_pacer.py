"""The pacer: a picture waits until everything sent before it has drained."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.congestion.pacer import Pacer, gap_s

steps = st.lists(st.tuples(st.floats(0, 0.1), st.integers(0, 1500)), max_size=50)


def test_a_picture_may_go_at_once_where_nothing_was_sent() -> None:
    """A link on which nothing was sent is free."""
    assert Pacer(100_000).free_in_s(5.0) == 0.0


def test_a_datagram_takes_its_time() -> None:
    """1000 bytes at 100 kbit/s keep the link busy for 80 ms."""
    pacer = Pacer(100_000)
    pacer.spend(1000, 1.0)
    assert pacer.free_in_s(1.0) == pytest.approx(0.080)
    assert pacer.free_in_s(1.05) == pytest.approx(0.030)
    assert pacer.free_in_s(1.2) == 0.0


def test_sound_goes_on_the_debt() -> None:
    """Sound is sent without waiting, and the picture waits for all of it."""
    pacer = Pacer(50_000)
    for packet in range(5):
        pacer.spend(150, packet * 0.001)
    assert pacer.free_in_s(0.004) == pytest.approx(5 * 0.024 - 0.004)


def test_what_is_measured_in_the_way_is_not_counted_twice() -> None:
    """A measured queue counts only as far as it exceeds the debt."""
    pacer = Pacer(100_000)
    pacer.spend(1000, 1.0)
    pacer.drain(50, 1.0)
    assert pacer.free_in_s(1.0) == pytest.approx(0.080)
    pacer.drain(400, 1.0)
    assert pacer.free_in_s(1.0) == pytest.approx(0.400)


def test_a_newer_measurement_replaces_an_older() -> None:
    """If a newer measurement is shorter, the wait falls back to the debt."""
    pacer = Pacer(100_000)
    pacer.spend(1000, 1.0)
    pacer.drain(400, 1.0)
    pacer.spend(500, 1.0)
    assert pacer.free_in_s(1.0) == pytest.approx(0.440)
    pacer.drain(0, 1.01)
    assert pacer.free_in_s(1.01) == pytest.approx(0.110)


def test_a_debt_takes_longer_on_a_slower_link() -> None:
    """The debt is in bits, so at half the rate it takes twice as long."""
    pacer = Pacer(100_000)
    pacer.spend(1000, 1.0)
    pacer.rate_bps = 50_000
    assert pacer.free_in_s(1.0) == pytest.approx(0.160)


def test_a_debt_that_no_queue_confirms_is_forgiven() -> None:
    """After `forgive` only the measured queue counts."""
    pacer = Pacer(100_000)
    pacer.spend(5000, 1.0)
    pacer.drain(30.0, 1.0)
    pacer.forgive()
    assert pacer.free_in_s(1.0) == pytest.approx(0.030)


def test_a_debt_is_bounded() -> None:
    """After 10 s every packet has arrived or is lost, however much was sent."""
    pacer = Pacer(1e6)
    for _ in range(100):
        pacer.spend(65_535, 1.0)
    assert pacer.free_in_s(1.0) == pytest.approx(10.0)


def test_time_that_runs_back_frees_nothing() -> None:
    """A time that falls, or NaN, counts as the latest time so far."""
    pacer = Pacer(100_000)
    pacer.spend(1000, 10.0)
    for now_s in (9.0, -math.inf, math.nan):
        assert pacer.free_in_s(now_s) == pytest.approx(0.080)
    assert pacer.free_in_s(10.08) == 0.0


@given(steps, st.floats(8e3, 5e7))
def test_no_more_leaves_than_the_rate(trace: list[tuple[float, int]], rate_bps: float) -> None:
    """A sender that waits as told never exceeds the rate by more than one datagram."""
    pacer, now_s, sent_bits, last_bits = Pacer(rate_bps), 0.0, 0, 0
    for pause_s, size_bytes in trace:
        now_s += pause_s
        now_s += pacer.free_in_s(now_s)
        assert sent_bits - last_bits <= now_s * rate_bps * (1 + 1e-6) + 1
        pacer.spend(size_bytes, now_s)
        last_bits = size_bytes * 8
        sent_bits += last_bits


def test_a_train_is_spread_at_its_pace() -> None:
    """1250 bytes at 1 Mbit/s put the next picture packet 10 ms later."""
    assert gap_s(1250, 1e6) == pytest.approx(0.010)
