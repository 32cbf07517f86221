"""Sentences for people, as codes with values."""

from __future__ import annotations

import ast
import json
import re
from functools import cache
from itertools import product
from pathlib import Path
from typing import Final

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples

import wax
from wax.errors import SourceError, WaxError
from wax.sentence import CATALOGUE, Sentence, read, says

_SOURCES: Final = Path(wax.__path__[0])
_PARTS: Final = re.compile(
    r"by|rate|tape|sent|sync|thesis|portaudio|(microphone|speaker)\.(default|named)"
    r"|camera\.named|says|fault|proof\.(?!passed$|late)\w+"
)
"""The codes of parts of sentences and of figures, which are not whole sentences."""


def _templates(code: str) -> list[str]:
    message = CATALOGUE[code]
    return [message] if isinstance(message, str) else list(message.values())


def _holes(code: str) -> set[str]:
    return set(re.findall(r"\{(\w+)\}", " ".join(_templates(code))))


@cache
def _made() -> list[tuple[str, list[str], set[str] | None]]:
    """Return each `Sentence(…)` in the source: its place, possible codes, and values' names."""
    made = []
    for path in sorted(_SOURCES.rglob("*.py")):
        source = path.read_text(encoding="utf-8")
        for node in ast.walk(ast.parse(source)) if "Sentence(" in source else ():
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "Sentence":
                where = f"{path.relative_to(_SOURCES)}:{node.lineno}"
                code, *values = node.args
                written = (one.value for one in ast.walk(code) if isinstance(one, ast.Constant))
                codes = [one for one in written if isinstance(one, str) and one in CATALOGUE]
                made.append((where, codes, _names(values[0]) if values else set()))
    return made


def _names(values: ast.expr) -> set[str] | None:
    if not isinstance(values, ast.Dict):
        return None
    return {str(key.value) for key in values.keys if isinstance(key, ast.Constant)}


def test_the_whole_source_was_read() -> None:
    """The search finds the source's sentences; otherwise the tests below would prove nothing."""
    assert len(_made()) > 150


def test_what_the_source_says_is_in_the_catalogue() -> None:
    """Each sentence is made of a code that is written out, and of just the values it has holes for;
    a form for a number may leave the number out.
    """
    for where, codes, names in _made():
        assert codes, f"{where}: no code of the catalogue"
        for code in codes:
            plural = set() if isinstance(CATALOGUE[code], str) else {"n"}
            assert names == _holes(code) | plural, f"{where}: {code}"


def test_nothing_is_in_the_catalogue_that_nobody_says() -> None:
    """Every code of the catalogue is used in the source."""
    said = {code for _, codes, _ in _made() for code in codes}
    assert set(CATALOGUE) == said


def test_each_is_english_that_reads_right() -> None:
    """Every template is a whole English sentence once its placeholders are filled."""
    for code, n in product(CATALOGUE, (1, 2, 30)):
        values = dict.fromkeys(_holes(code), "the door") | {"n": n}
        text = str(Sentence(code, values))
        assert not re.search(r"[{…]|  |^\s|\s$", text), text
        if not _PARTS.match(code) and not text.endswith("the door"):
            assert not text[0].islower() or text.startswith("the door"), text
            assert text.endswith((".", "?")), text


@pytest.mark.parametrize(
    ("sentence", "english"),
    [
        (Sentence("door.full", {"n": 1}), "The only place is taken; try again later."),
        (Sentence("door.full", {"n": 1200}), "All 1,200 places are taken; try again later."),
        (Sentence("rate.mbit", {"rate": 2.0}), "2 Mbit/s"),
        (Sentence("rate.mbit", {"rate": 1.2}), "1.2 Mbit/s"),
        (
            Sentence("stop.pressed", {"by": Sentence("by.named", {"name": "Ada"})}),
            "Stopped by Ada. Release the stop, then drive again.",
        ),
        (says("The arm is stuck {so}."), "The arm is stuck {so}."),
        (Sentence("door.full"), "All … places are taken; try again later."),
        (Sentence("no.such", {"text": "The arm is stuck.", "n": 3}), "The arm is stuck., 3"),
        (Sentence("no.such"), "no.such"),
    ],
)
def test_in_words(sentence: Sentence, english: str) -> None:
    """Numbers, nested sentences and foreign text are formatted, and even wrong codes give text."""
    assert str(sentence) == english


_VALUES = st.recursive(
    st.text() | st.integers() | st.floats(),
    lambda inner: st.builds(Sentence, st.text(), st.dictionaries(st.text(), inner)),
    max_leaves=4,
)


@examples(200)
@given(
    st.sampled_from([*CATALOGUE, "", "no.such"]), st.dictionaries(st.text(), _VALUES, max_size=3)
)
def test_words_are_found_for_anything(code: str, values: dict[str, str | int | float]) -> None:
    """`str` of a sentence never raises, whatever its code and values."""
    holes = _holes(code) if code in CATALOGUE else set()
    sentence = Sentence(code, values | dict.fromkeys(holes, "") if len(values) % 2 else values)
    assert isinstance(str(sentence), str)
    assert isinstance(hash(sentence), int)


_FINITE = st.text() | st.integers(-(2**53), 2**53) | st.floats(allow_nan=False, width=32)
_SENT = st.recursive(
    st.builds(Sentence, st.text(), st.dictionaries(st.text(), _FINITE)),
    lambda inner: st.builds(Sentence, st.text(), st.dictionaries(st.text(), inner)),
    max_leaves=5,
)


@examples(100)
@given(_SENT)
def test_the_wire_keeps_it(sentence: Sentence) -> None:
    """A sentence survives encoding and decoding."""
    assert read(sentence.wire()) == sentence


def test_the_wire_is_short() -> None:
    """Empty values are not sent."""
    stop = Sentence("stop.pressed", {"by": Sentence("by.host")})
    assert json.dumps(stop.wire()) == (
        '{"code": "stop.pressed", "values": {"by": {"code": "by.host"}}}'
    )


@pytest.mark.parametrize("wire", [None, "says", 3, {}, {"code": 3}, {"code": "x", "values": [1]}])
def test_what_is_none_is_refused(wire: object) -> None:
    """Anything but a code and values raises `ValueError`."""
    with pytest.raises(ValueError, match="Sentence"):
        read(wire)


def test_an_error_is_a_sentence() -> None:
    """An error's sentence keeps its code; a plug-in's text is shown unchanged."""
    ours, theirs = Sentence("camera.hangs", {"camera": 0}), "My camera has no film."
    assert (SourceError(ours).sentence, SourceError(theirs).sentence) == (ours, says(theirs))
    assert [str(WaxError(one)) for one in (ours, theirs)] == [str(ours), theirs]
