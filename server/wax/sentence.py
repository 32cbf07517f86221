"""Sentences for people as codes with values, so that the page can show them in any language.

`sentences.json` has the English: for each code a template with ``{name}`` for each value, or one
for each plural form, chosen by the value ``n``. The page has a file with the same codes and
placeholders for each of its other languages. Logs, records, tapes and the command line use `str`.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping  # noqa: TC003  # pydantic looks it up where a state is sent
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Final

from pydantic import Field, TypeAdapter

_HOLE: Final = re.compile(r"\{(\w+)\}")
_MISSING: Final = "…"
_DIGITS: Final = 3

CATALOGUE: Final[Mapping[str, str | Mapping[str, str]]] = json.loads(
    Path(__file__).with_name("sentences.json").read_text(encoding="utf-8")
)
"""The English of each code."""


@dataclass(frozen=True, slots=True)
class Sentence:
    """A sentence, or a part of one: a value may be a sentence, too."""

    code: str
    # Empty values are not sent, to spare a modem.
    values: Annotated[
        Mapping[str, str | int | float | Sentence], Field(exclude_if=lambda values: not values)
    ] = field(default_factory=dict)

    def __hash__(self) -> int:
        return hash(self.code)

    def __str__(self) -> str:
        """Return the English; never raises, whatever the code and the values are."""
        template = CATALOGUE.get(self.code)
        if template is None:
            return ", ".join(_text(value) for value in self.values.values()) or self.code
        if not isinstance(template, str):
            is_one = self.values.get("n") == 1
            template = template["one" if is_one and "one" in template else "other"]
        return _HOLE.sub(lambda hole: _text(self.values.get(hole[1], _MISSING)), template)

    def wire(self) -> dict[str, Any]:
        """Return the sentence as it is encoded in messages to a page."""
        wire: dict[str, Any] = _WIRE.dump_python(self)
        return wire


_WIRE: Final = TypeAdapter(Sentence)


def read(wire: object) -> Sentence:
    """Decode a sentence from its wire form; raises `ValueError`."""
    return _WIRE.validate_python(wire)


def says(text: str) -> Sentence:
    """Return foreign text, such as a plug-in's, as a sentence that is shown unchanged."""
    return Sentence("says", {"text": text})


def _text(value: object) -> str:
    """Format a value as the page does in English."""
    if isinstance(value, float) and math.isfinite(value):
        rounded = round(value, _DIGITS)
        value = int(rounded) if rounded.is_integer() else rounded
    return f"{value:,}" if isinstance(value, int | float) else str(value)
