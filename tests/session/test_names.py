"""The names that viewers give themselves."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.protocol.messages import MAX_NAME_CHARS
from wax.session import names
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
        "\N{GREEK CAPITAL LETTER ETA}ost",
        "H\N{CYRILLIC SMALL LETTER O}\N{CYRILLIC SMALL LETTER DZE}t",
        "adrnin",
        "the h\N{GREEK SMALL LETTER OMICRON}st",
        "\N{CYRILLIC CAPITAL LETTER EN}\N{GREEK CAPITAL LETTER OMICRON}ST",
        "Gues\N{GREEK CAPITAL LETTER TAU} 7",
        "Guest l2",
        "guest \N{SEGMENTED DIGIT ONE}",
        "\N{CYRILLIC CAPITAL LETTER VE}ob",
        "B\N{MATHEMATICAL BOLD SMALL O}b",
        "R\N{CYRILLIC SMALL LETTER O}ver",
        "rover",
    ],
)
def test_nobody_can_be_mistaken_for_somebody_else(name: str) -> None:
    """Titles, other guests' numbers and names that are present are refused, however written."""
    assert refusal(name, ["Bob"], robot="Rover") is not None


@pytest.mark.parametrize(
    "name",
    [
        "Ada",
        "Hosta",
        "Guest of honour",
        "Bobby",
        "小林",
        "☃",
        "Ελένη",
        "Оля",
        "Иван",
        "محمد",
        "Zoë",
    ],
)
def test_other_names_are_free(name: str) -> None:
    """A name that is only a little similar is accepted."""
    assert refusal(name, ["Bob", "☺", "Olga"]) is None


@given(st.text(max_size=MAX_NAME_CHARS), st.text(max_size=MAX_NAME_CHARS))
def test_looking_alike_is_mutual(one: str, other: str) -> None:
    """The order does not matter, and a name looks like itself."""
    assert (refusal(one, [other]) is None) == (refusal(other, [one]) is None) or (
        refusal(one, []) is not None or refusal(other, []) is not None
    )
    assert refusal(one, [one]) is not None


def test_each_name_is_folded_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """A new name among a hundred costs only its own characters, not those of all the others."""
    others = [f"{chr(0xFDFA) * 20}{number:03}" for number in range(100)]
    assert refusal("Ada", others) is None
    looked: list[str] = []

    def note(name: str) -> str:
        looked.append(name)
        return name

    monkeypatch.setattr(names, "skeleton", note)
    assert refusal("Grace", others) is None
    assert looked == ["Grace"]
