"""Strangers' text made safe for logs and records."""

from __future__ import annotations

import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples

from wax.logs.printable import printable


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("Zoë 漢字 🤖", "Zoë 漢字 🤖"),
        ("a\nb\x1b[31m\x7f", r"a\nb\x1b[31m\x7f"),
        ("\u202ee\u200b\u2028", r"\u202ee\u200b\u2028"),
        ("\ud800", r"\ud800"),
        ("x" * 21, "x" * 19 + "…"),
        ("\n" * 20, r"\n" * 9 + "\\…"),
    ],
)
def test_what_is_hidden_is_shown(text: str, shown: str) -> None:
    """Controls and bidirectional marks are escaped, and long text is cut."""
    assert printable(text, 20) == shown


@examples(200)
@given(st.text(st.characters(codec=None), max_size=60), st.integers(1, 50))
def test_any_text_becomes_one_short_visible_line(text: str, most: int) -> None:
    """Any text becomes one short printable line; a second call changes nothing."""
    shown = printable(text, most)
    assert len(shown) <= most
    assert not {unicodedata.category(one) for one in shown} & {"Cc", "Cf", "Cs", "Zl", "Zp"}
    assert printable(shown, most) == shown
