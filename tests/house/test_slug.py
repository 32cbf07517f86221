"""Names as topics and ids have them."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.house.slug import slug


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("Rover", "rover"),
        ("The old  Rover-2", "the_old_rover_2"),
        ("home/garage", "home_garage"),
        ("Rövér", "rover_"),
        ('"Rover" + #', "rover_"),
        ("🤖", ""),
        ("---", ""),
        ("r" * 200, "r" * 40 + "_"),
    ],
)
def test_a_name_stays_readable(text: str, expected: str) -> None:
    """As far as it can; a digest follows where more is lost than case and what separates."""
    if expected and not expected.endswith("_"):
        assert slug(text) == expected
    else:
        assert re.fullmatch(expected + "[0-9a-f]{8}", slug(text))


@given(st.text())
def test_any_name_is_fit(text: str) -> None:
    """Short, of letters that every topic and id may have, and the same each time."""
    assert re.fullmatch("[a-z0-9_]{1,49}", slug(text))
    assert slug(text) == slug(text)


@given(st.text(), st.text())
def test_two_names_stay_two(one: str, other: str) -> None:
    """Unless they differ in case and separators only."""

    def plain(text: str) -> str:
        return re.sub(r"[ _/-]+", "_", text.lower()).strip("_")

    assert slug(one) != slug(other) or plain(one) == plain(other)
