"""The names that viewers give themselves."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.protocol.messages import MAX_NAME_CHARS
from wax.session.names import clean_name, refusal


@pytest.mark.parametrize(
    ("given_name", "shown"),
    [
        ("  Ada  Lovelace ", "Ada Lovelace"),
        ("", ""),
        (" \t\n\x00 ", ""),
        ("a\u202eb\nc", "a b c"),
        ("x" * 100, "x" * MAX_NAME_CHARS),
        ("<b>Zoë</b>", "<b>Zoë</b>"),
        ("Z" + "\u0351" * 20 + "algo", "Z\u0351\u0351algo"),
    ],
)
def test_names_are_one_short_visible_line(given_name: str, shown: str) -> None:
    """A name is trimmed, bounded and free of control characters; markup stays plain text."""
    assert clean_name(given_name) == shown


@given(st.text())
def test_any_name_is_bounded(name: str) -> None:
    """No name is longer than allowed, spans lines, or begins or ends with a space."""
    shown = clean_name(name)
    assert len(shown) <= MAX_NAME_CHARS
    assert shown == shown.strip()
    assert shown.isprintable()


@pytest.mark.parametrize(
    "name",
    [
        "host",
        "The Host",
        "t h e  h-o-s-t",
        "ＨＯＳＴ",
        "Hóst",
        "Guest 7",
        "operator",
        "Bob",
        "b ob.",
    ],
)
def test_nobody_is_taken_for_somebody_else(name: str) -> None:
    """Titles, other guests' numbers and names that are present are refused, however written."""
    assert refusal(name, ["Bob"]) is not None


@pytest.mark.parametrize("name", ["Ada", "Hosta", "Guest of honour", "Bobby", "小林", "☃"])
def test_other_names_are_free(name: str) -> None:
    """What only looks a little alike is nobody else."""
    assert refusal(name, ["Bob", "☺"]) is None
