"""The rate limit: a burst at once, the rate in the long run, never more."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from wax.token_bucket import TokenBucket, TokenBuckets


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
