"""Median and maximum without keeping the measurements."""

from __future__ import annotations

import math
import statistics

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples

from wax.session.link_statistics import Spread


@examples(200)
@given(st.lists(st.floats(0, 1e9), min_size=1, max_size=50))
def test_it_is_the_median_within_a_step(values: list[float]) -> None:
    """It is within 3 % of the true lower median, and the maximum is exact."""
    spread = Spread()
    for value in values:
        spread.add(value)
    assert spread.worst == max(values)
    assert spread.median == pytest.approx(statistics.median_low(values), rel=0.03, abs=0.011)


def test_invalid_measurements_are_ignored() -> None:
    """Unknown, negative, infinite and NaN change nothing."""
    spread = Spread()
    for value in (None, -1.0, math.inf, math.nan):
        spread.add(value)
    assert (spread.median, spread.worst) == (None, None)
