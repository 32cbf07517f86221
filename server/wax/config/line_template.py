r"""Writes and parses lines of text with numbers in them, such as ``m {left} {right}\r`` (pure).

A template is text with named fields in braces. Of Python's format strings it has only the names and
a number format (``{left:.2f}``): no attributes, indices or conversions. To parse a line, each field
matches a decimal number and all other text itself; that takes time linear in the line's length,
whatever a robot sends.
"""

from __future__ import annotations

import re
import string
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

MAX_CHARS: Final = 120
ANY: Final = "_"
"""The field of a number that is ignored."""

_FORMAT: Final = re.compile(r"\+?(0?[1-9])?(d|(\.[0-6])?f)?")
# Possessive quantifiers never backtrack, so no line can make the match slow.
_NUMBER: Final = r"((?>[+-]?+(?:[0-9]{1,12}+(?:\.[0-9]{0,12}+)?+|(?i:nan|inf|ovf|null|none))|))"
"""A number, or what boards print without one: Arduino's `Print::print` writes nan, inf and ovf."""
_ENDS: Final = "\r\n"


class LineTemplate:
    """A line whose `names` are filled in or parsed; raises `ValueError` with what is wrong."""

    def __init__(self, text: str, allowed: Collection[str]) -> None:
        _check_text(text)
        self.text = text
        self._parts = [_checked(*part, allowed) for part in _parse(text)]
        self.names = tuple(name for _, name, _ in self._parts if name)
        self._pattern = re.compile(_pattern(self._parts))

    @property
    def ending(self) -> str:
        """The carriage returns and line feeds at the end of the line."""
        return self.text[len(self.text.rstrip(_ENDS)) :]

    def said(self, values: Mapping[str, float]) -> bytes:
        """Return the line with these numbers, rounded if their format has no decimals."""
        return "".join(
            literal + (_written(values[name], form) if name else "")
            for literal, name, form in self._parts
        ).encode("ascii")

    def found(self, line: str) -> dict[str, float] | None:
        """Parse the numbers in a line without its end; None if it does not match.

        A field that is empty, or holds a word such as nan, is left out.
        """
        match = self._pattern.fullmatch(line)
        if match is None or (self.names and not any(match.groups())):
            return None
        return {
            name: float(number)
            for name, number in zip(self.names, match.groups(), strict=True)
            if number[-1:].isdigit() or number[-1:] == "."
        }


def _check_text(text: str) -> None:
    if len(text) > MAX_CHARS:
        raise ValueError(f"is {len(text)} characters long; a line has at most {MAX_CHARS}")
    if not text.isascii():
        raise ValueError(f"{text!r} has characters that are not ASCII; boards understand no others")
    if re.search(r"\\[rn]", text):
        raise ValueError(
            f"{text} has a backslash, not an end of line; write it in double quotes, in which"
            " \\r and \\n mean what they say"
        )


def _parse(text: str) -> list[tuple[str, str, str, str]]:
    try:
        parts = list(string.Formatter().parse(text))
    except ValueError as error:
        raise ValueError(
            f"{text!r} has a brace without its other half; write {{{{ or }}}} for a brace itself"
        ) from error
    # The parser returns "" for a field without a name, None for no field.
    return [
        (literal, "" if name is None else name or "?", form or "", conversion or "")
        for literal, name, form, conversion in parts
    ]


def _checked(
    literal: str, name: str, form: str, conversion: str, allowed: Collection[str]
) -> tuple[str, str, str]:
    if not name:
        return literal, "", ""
    places = ", ".join(f"{{{one}}}" for one in allowed) or "none"
    if conversion or not re.fullmatch(r"[a-z_?]+", name):
        raise ValueError(
            f"{{{name}{'!' + conversion if conversion else ''}}} is more than a name;"
            f" possible are: {places}"
        )
    if name not in allowed:
        raise ValueError(f"there is no {{{name.strip('?')}}} here; possible are: {places}")
    if not _FORMAT.fullmatch(form):
        raise ValueError(
            f"{{{name}:{form}}} is no format for a number; write {{{name}}} for a whole number,"
            f" {{{name}:.2f}} for decimals"
        )
    return literal, name, form


def _pattern(parts: list[tuple[str, str, str]]) -> str:
    """Return the pattern of a received line, without its end and spaces at either end."""
    texts = [text for text, _, _ in parts] or [""]
    texts[0] = texts[0].lstrip()
    if parts and not parts[-1][1]:
        texts[-1] = texts[-1].rstrip()
    numbers = [_NUMBER if name else "" for _, name, _ in parts] or [""]
    return "".join(re.escape(text) + number for text, number in zip(texts, numbers, strict=True))


def _written(value: float, form: str) -> str:
    if not form.endswith("f"):
        return format(round(value), form)
    written = format(value, form)
    return format(0.0, form) if float(written) == 0.0 else written  # never -0.00
