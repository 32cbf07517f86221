"""Names made valid for topics and ids."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.house.slug import client_id, slug


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
    """A slug stays readable; a digest follows if more than case and separators is lost."""
    if expected and not expected.endswith("_"):
        assert slug(text) == expected
    else:
        assert re.fullmatch(expected + "[0-9a-f]{8}", slug(text))


@given(st.text())
def test_any_name_is_fit(text: str) -> None:
    """Any text gives the same short slug each time, valid in every topic and id."""
    assert re.fullmatch("[a-z0-9_]{1,49}", slug(text))
    assert slug(text) == slug(text)


@given(st.text(), st.text())
def test_two_names_stay_two(one: str, other: str) -> None:
    """Two names have two slugs unless they differ only in case and separators."""

    def plain(text: str) -> str:
        return re.sub(r"[ _/-]+", "_", text.lower()).strip("_")

    assert slug(one) != slug(other) or plain(one) == plain(other)


@given(st.text(min_size=1, max_size=100))
def test_every_broker_takes_the_identifier(topic: str) -> None:
    """A client id has 1 to 23 letters and digits (MQTT 5, 3.1.3.1) and depends on topic and use."""
    own = client_id(topic, "server")
    assert re.fullmatch("[0-9a-z]{1,23}", own)
    assert own == client_id(topic, "server") != client_id(topic, "trial")
    assert own != client_id(f"{topic}1", "server")
