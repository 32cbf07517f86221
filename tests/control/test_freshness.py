"""How old a command may be."""

from __future__ import annotations

import math

import pytest

from wax.control.freshness import MAX_ONE_WAY_S, allowance_s, is_from_future, is_too_old


@pytest.mark.parametrize(
    ("one_way_s", "expected_s"),
    [
        (None, 0.0),
        (0.0, 0.0),
        (-1.0, 0.0),
        (math.nan, 0.0),
        (0.2, 0.2),
        (5.0, 1.0),
        (math.inf, 1.0),
    ],
)
def test_allowance(one_way_s: float | None, expected_s: float) -> None:
    """The measured delay is forgiven up to a second; what is unknown or no delay is not."""
    assert allowance_s(one_way_s) == expected_s
    assert expected_s <= MAX_ONE_WAY_S


@pytest.mark.parametrize(
    ("sent_s", "one_way_s", "expected"),
    [
        (10.0, None, False),
        (9.875, None, False),
        (9.874, None, True),
        (9.75, 0.125, False),
        (9.749, 0.125, True),
        (11.0, None, False),
        (-math.inf, 0.125, True),
        (math.nan, 0.125, True),
    ],
)
def test_age(sent_s: float, one_way_s: float | None, expected: bool) -> None:
    """A command is too old beyond the limit and the allowance, and always without a real stamp."""
    assert is_too_old(sent_s, 10.0, max_age_s=0.125, one_way_s=one_way_s) is expected


@pytest.mark.parametrize(
    ("sent_s", "one_way_s", "expected"),
    [
        (10.0, None, False),
        (10.049, None, False),
        (10.051, None, True),
        (10.149, 0.1, False),
        (10.151, 0.1, True),
        (math.inf, 0.1, True),
        (math.nan, 0.1, True),
    ],
)
def test_future(sent_s: float, one_way_s: float | None, expected: bool) -> None:
    """A stamp ahead by more than 50 ms and the allowance comes from a clock that is not aligned."""
    assert is_from_future(sent_s, 10.0, one_way_s=one_way_s) is expected
