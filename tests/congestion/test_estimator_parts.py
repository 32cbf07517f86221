"""The parts of the estimator, compared with a plain way to compute the same."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.congestion.delivery_rate import Arrival, DeliveryRate, DispersionEstimator
from wax.congestion.queuing_delay import Jitter
from wax.congestion.send_history import SendHistory

steps = st.lists(st.tuples(st.floats(0.001, 0.5), st.integers(1, 1500)), min_size=1, max_size=40)


@given(steps, st.floats(0, 5), st.floats(0, 5))
def test_the_log_counts_what_left_between(
    trace: list[tuple[float, int]], after_s: float, more_s: float
) -> None:
    """The bytes between two moments are those added after the first, up to the second."""
    log, now_s, sent = SendHistory(), 0.0, []
    for pause_s, size_bytes in trace:
        now_s += pause_s
        log.add(size_bytes, now_s)
        sent.append((now_s, size_bytes))
    until_s = after_s + more_s
    wanted = sum(size for at_s, size in sent if after_s < at_s <= until_s)
    assert log.between(after_s, until_s) == wanted


def test_the_log_is_bounded() -> None:
    """After 100 000 datagrams the last are still known and the first forgotten."""
    log = SendHistory()
    for number in range(100_000):
        log.add(100, number / 1000)
    assert log.between(99.0, 200.0) == 100 * 999
    assert log.between(-1.0, 200.0) <= 100 * 10_000


@given(steps, st.floats(1e4, 1e7))
def test_the_queue_now_is_that_of_a_link_of_the_rate(
    trace: list[tuple[float, int]], rate_bps: float
) -> None:
    """The wait of any one packet gives the queue that the whole trace leaves."""
    log, now_s, free_s, joined = SendHistory(), 0.0, 0.0, []
    for pause_s, size_bytes in trace:
        now_s += pause_s
        log.add(size_bytes, now_s)
        free_s = max(free_s, now_s) + size_bytes * 8 / rate_bps
        joined.append((now_s, free_s - now_s))
    at_s, waiting_s = joined[len(joined) // 2]
    now_s += 0.01
    wanted_s = max(0.0, free_s - now_s)
    assert log.queue_s(waiting_s, at_s, now_s, rate_bps) == pytest.approx(wanted_s, abs=1e-6)


@given(st.lists(st.floats(0, 2), min_size=1, max_size=300))
def test_jitter_is_the_quantile_above_the_least(ways_s: list[float]) -> None:
    """It is the value at 99 % of the sorted ways, minus the first."""
    jitter = Jitter()
    for number, way_s in enumerate(ways_s):
        jitter.add(way_s, number / 50)
    ordered = sorted(ways_s)
    wanted_ms = (ordered[math.floor(0.99 * (len(ordered) - 1) + 0.5)] - ordered[0]) * 1000
    assert jitter.ms == pytest.approx(wanted_ms, abs=1e-6)


def test_jitter_forgets_after_8_s() -> None:
    """A packet that was late 9 s ago no longer counts."""
    jitter = Jitter()
    jitter.add(0.0, 0.0)
    jitter.add(0.5, 0.1)
    jitter.add(0.0, 1.0)
    assert jitter.ms == pytest.approx(500)
    jitter.add(0.01, 9.0)
    assert jitter.ms == pytest.approx(10)


def test_a_full_link_shows_its_rate_through_a_stall() -> None:
    """Packets that leave a full queue at 1 Mbit/s show it, even if one was held for 150 ms."""
    rate = DeliveryRate()
    arrived_s = 0.0
    for number in range(40):
        arrived_s += 0.008 + (0.15 if number == 20 else 0.0)
        rate.add(Arrival(number * 0.001, arrived_s, 1000 * number), base_s=0.0)
    assert rate.rate_bps() == pytest.approx(1e6, rel=0.01)


def test_a_link_with_pauses_shows_nothing() -> None:
    """Packets with none before them in the queue say nothing about the rate."""
    rate = DeliveryRate()
    for number in range(40):
        rate.add(Arrival(number * 0.02, number * 0.02, 1000 * number), base_s=0.0)
    assert rate.rate_bps() is None


def _train(sent_in_s: float, came_in_s: float) -> list[Arrival]:
    """Return the first and the last packet of a train of 20 kbit."""
    return [Arrival(0.0, 0.0, 0), Arrival(sent_in_s, came_in_s, 2500)]


@given(st.integers(1, 200), st.floats(2e4, 2e7))
def test_even_trains_show_the_rate(count: int, rate_bps: float) -> None:
    """Packet trains that all arrived at the rate bound it from below."""
    dispersion = DispersionEstimator()
    for number in range(count):
        dispersion.add(_train(0.001 / 2e7, 20_000 / rate_bps), number / 30)
    assert dispersion.min_bps(0.0, startup=False) == pytest.approx(rate_bps, rel=1e-3)


def test_noisy_paths_weaken_what_trains_show() -> None:
    """One train over a path that varies by 10 ms shows less than over a smooth one."""
    dispersion = DispersionEstimator()
    dispersion.add(_train(0.01, 0.02), 0.0)
    assert dispersion.min_bps(0.01, startup=False) < dispersion.min_bps(0.0, startup=False) / 2
    assert dispersion.min_bps(0.01, startup=True) > dispersion.min_bps(0.01, startup=False)


def test_a_compressed_train_shows_its_pace_at_most() -> None:
    """A train that arrives all at once was held up; the link is shown to be as fast as it left."""
    dispersion = DispersionEstimator()
    dispersion.add(_train(0.02, 0.0), 0.0)
    assert dispersion.min_bps(0.0, startup=False) == pytest.approx(1e6)


@given(
    st.lists(st.tuples(st.floats(0, 0.2), st.integers(1, 3000)), max_size=60),
    st.integers(0, 60),
    st.floats(0, 1),
    st.floats(0, 1),
    st.floats(8e3, 1e7),
)
def test_the_queue_is_what_each_datagram_would_find(
    sent: list[tuple[float, int]], newest: int, queued_s: float, later_s: float, rate_bps: float
) -> None:
    """Each packet waits for those before it."""
    history, now_s = SendHistory(), 100.0
    left: list[tuple[float, int]] = []
    for pause_s, size in sent:
        now_s += pause_s
        history.add(size, now_s)
        left.append((now_s, size))
    at_s = left[newest % len(left)][0] if left else now_s
    before_s, expected_s = at_s, queued_s
    for left_s, size in left:
        if left_s > at_s:
            expected_s = max(0.0, expected_s - (left_s - before_s)) + size * 8 / rate_bps
            before_s = left_s
    expected_s = max(0.0, expected_s - (now_s + later_s - before_s))
    found_s = history.queue_s(queued_s, at_s, now_s + later_s, rate_bps)
    assert found_s == pytest.approx(expected_s, abs=1e-6)
