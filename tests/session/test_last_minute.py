"""What a page's counters grew by in the last minute."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from wax.session.last_minute import LastMinute


def test_what_is_older_than_a_minute_is_forgotten() -> None:
    """A freeze counts for a minute and then no more."""
    frozen = LastMinute()
    for second in range(100):
        frozen.count(0.0 if second < 10 else 400.0, float(second))
        assert frozen.sum == (400.0 if 10 <= second <= 70 else 0.0)


def test_a_counter_that_restarts_takes_nothing_back() -> None:
    """A fresh peer's counters start at zero; what came before stays counted."""
    made_up = LastMinute()
    for second, value in enumerate([100.0, 130.0, None, 0.0, 20.0]):
        made_up.count(value, float(second))
    assert made_up.sum == 50.0


@given(st.lists(st.floats(0, 1e6), max_size=300))
def test_memory_is_bounded_and_the_sum_never_negative(values: list[float]) -> None:
    """However often a page reports, a minute is at most 61 entries, and no sum is below zero."""
    counted = LastMinute()
    for tick, value in enumerate(values):
        counted.count(value, tick / 4)
        assert len(counted._grown) <= 61
        assert counted.sum >= 0
