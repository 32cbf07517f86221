"""How old a command may be."""

from __future__ import annotations

import math

import pytest
from tests.control.rules import RULES

from wax.control.command_freshness import allowance_s, is_from_future, is_too_old, time_to_live_s


@pytest.mark.parametrize(
    ("one_way_s", "expected_s"),
    [
        (None, 0.0),
        (0.0, 0.0),
        (-1.0, 0.0),
        (math.nan, 0.0),
        (0.2, 0.2),
        (5.0, 2.0),
        (math.inf, 2.0),
    ],
)
def test_allowance(one_way_s: float | None, expected_s: float) -> None:
    """The measured delay is allowed for, up to two seconds; an unknown or invalid one is not."""
    assert allowance_s(one_way_s) == expected_s


@pytest.mark.parametrize(
    ("one_way_s", "expected_s"),
    [
        (None, 0.15),
        (math.nan, 0.15),
        (0.25, 0.4),
        (0.35, 0.5),
        (0.351, None),
        (5.0, None),
        (math.inf, None),
    ],
)
def test_time_to_live(one_way_s: float | None, expected_s: float | None) -> None:
    """A command's time-to-live is the age plus the link's delay; a too slow link has none."""
    assert time_to_live_s(one_way_s, RULES) == expected_s


@pytest.mark.parametrize(
    ("sent_s", "expected"),
    [
        (10.0, False),
        (9.875, False),
        (9.874, True),
        (11.0, False),
        (-math.inf, True),
        (math.nan, True),
    ],
)
def test_age(sent_s: float, expected: bool) -> None:
    """A command is too old beyond its time-to-live, and always without a valid timestamp."""
    assert is_too_old(sent_s, 10.0, 0.125) is expected


@pytest.mark.parametrize(
    ("sent_s", "one_way_s", "expected"),
    [
        (10.0, None, False),
        (10.049, None, False),
        (10.051, None, True),
        (10.149, 0.1, False),
        (10.151, 0.1, True),
        (math.inf, 0.1, True),
        (math.inf, math.inf, True),
        (math.nan, 0.1, True),
    ],
)
def test_future(sent_s: float, one_way_s: float | None, expected: bool) -> None:
    """A timestamp ahead by more than 50 ms plus the allowance means a misaligned clock."""
    assert is_from_future(sent_s, 10.0, one_way_s=one_way_s) is expected


def test_future_begins_after_the_allowance() -> None:
    """A timestamp that is ahead by exactly the allowance is accepted."""
    assert not is_from_future(0.05, 0.0, one_way_s=None)
