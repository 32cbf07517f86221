"""Rate limits: a burst, the rate in the long run, never more; and the last request counts."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.rate_limits import LastWins, MinuteLimits, TokenBucket, TokenBuckets


def test_a_burst_then_the_rate() -> None:
    """A full bucket gives its burst at once and refills at its rate."""
    bucket = TokenBucket(rate_hz=10.0, burst=3)
    assert [bucket.take(5.0) for _ in range(4)] == [True, True, True, False]
    assert not bucket.take(5.05)
    assert bucket.take(5.11)
    assert [bucket.take(99.0) for _ in range(4)] == [True, True, True, False]


def test_time_that_runs_back_fills_nothing() -> None:
    """Nor does the time until the clock is back where it was."""
    bucket = TokenBucket(rate_hz=8.0, burst=1)
    assert bucket.take(5.0)
    assert not bucket.take(4.0)
    assert not bucket.take(5.0625)
    assert bucket.take(5.125)


@given(st.lists(st.floats(-1, 2), max_size=200))
def test_never_more_than_burst_and_rate(steps_s: list[float]) -> None:
    """Whatever the clock does, at most the burst and what the time has refilled is taken."""
    bucket = TokenBucket(rate_hz=5.0, burst=4)
    now_s = latest_s = 0.0
    passed = 0
    for step_s in steps_s:
        now_s += step_s
        latest_s = max(latest_s, now_s)
        passed += bucket.take(now_s)
        assert passed <= 4 + latest_s * 5.0 + 1e-6


def test_each_key_has_a_bucket_of_its_own() -> None:
    """One key's use takes nothing from another's."""
    buckets = TokenBuckets(rate_hz=1.0, burst=2, most=10)
    assert [buckets.take("a", 5.0) for _ in range(3)] == [True, True, False]
    assert buckets.take("b", 5.0)
    assert buckets.take("a", 6.0)
    assert not buckets.take("a", 6.0)


@given(gaps_s=st.lists(st.floats(0.0, 40.0), max_size=60), each=st.integers(1, 5))
def test_no_minute_has_more(gaps_s: list[float], each: int) -> None:
    """Requests may come at any time, and one within the limit is never refused."""
    limits = MinuteLimits(each=each, most=4)
    now_s, taken_s = 0.0, list[float]()
    for gap_s in gaps_s:
        now_s += gap_s
        recent = sum(now_s - one_s < 60.0 for one_s in taken_s)
        assert limits.taken("a", now_s) == recent
        assert limits.take("a", now_s) is (recent < each)
        if recent < each:
            taken_s.append(now_s)


def test_a_minute_is_over_after_sixty_seconds() -> None:
    """What was taken exactly 60 s ago no longer counts."""
    limits = MinuteLimits(each=1, most=4)
    assert [limits.take("a", now_s) for now_s in (1.0, 60.9, 61.0)] == [True, False, True]


def test_the_least_recent_is_forgotten() -> None:
    """However many keys come, few are kept; the most recent one is among them."""
    limits = MinuteLimits(each=1, most=3)
    assert [limits.take(key, 0.0) for key in "abcd"] == [True] * 4
    assert [limits.take(key, 1.0) for key in "dcba"] == [False, False, False, True]


def test_the_last_request_wins() -> None:
    """The first runs at once, then one every two seconds: the newest, and only once."""
    done: list[tuple[float, int]] = []
    now_s = 0.0
    names: LastWins[int] = LastWins(
        lambda number: done.append((now_s, number)), TokenBucket(rate_hz=0.5, burst=1)
    )
    names.run_waiting(now_s)
    assert (done, names.is_waiting) == ([], False)
    for step in range(100):
        now_s = step / 20
        names.submit(step, now_s)
    assert names.is_waiting
    for step in range(100, 300):
        now_s = step / 20
        names.run_waiting(now_s)
    assert [number for _, number in done] == [0, 40, 80, 99]
    assert [at_s for at_s, _ in done] == pytest.approx([0.0, 2.0, 4.0, 6.0])
