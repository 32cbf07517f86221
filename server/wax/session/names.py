"""What viewers call themselves and their tasks; `wax.protocol.messages` bounds both. Pure."""

from __future__ import annotations

import re
import unicodedata
from functools import lru_cache
from typing import TYPE_CHECKING, Final

from wax.protocol.messages import MAX_NAME_CHARS
from wax.sentence import Sentence
from wax.session.lookalikes import skeleton

if TYPE_CHECKING:
    from collections.abc import Iterable

_MAX_MARKS: Final = 2
"""Combining marks in a row; more would cover the line above."""
_TITLES: Final = (
    "host",
    "admin",
    "administrator",
    "moderator",
    "operator",
    "server",
    "wax",
    "somebody",
)
_GUEST: Final = re.compile(r"guest[\dlo]+")
"""0 and 1 look like O and l."""


def clean_name(name: str) -> str:
    """Reduce a name to one line of visible characters, at most `MAX_NAME_CHARS` long."""
    return clean_line(name, MAX_NAME_CHARS)


def clean_line(text: str, most: int) -> str:
    """Reduce a text to one line of visible characters, at most `most` long."""
    visible = "".join(c if unicodedata.category(c)[0] not in "CZ" else " " for c in text)
    bounded = re.sub(r"\s+", " ", _without_piles(visible))
    return bounded.strip()[:most].strip()


def refusal(name: str, others: Iterable[str], robot: str = "") -> Sentence | None:
    """Return why a guest may not have this name, None if they may.

    A refused name is, or looks like, a title, a nameless guest ("Guest 3"), the `robot`'s name or
    somebody else's.
    """
    looks = _looks(name)
    is_guest = any(_GUEST.fullmatch(one) for one in looks)
    if is_guest or looks & _RESERVED or (robot and looks & _looks(robot)):
        return Sentence("name.title", {"name": name})
    if any(_looks(other) & looks for other in others):
        return Sentence("name.taken", {"name": name})
    return None


@lru_cache(maxsize=1024)
def _looks(name: str) -> frozenset[str]:
    """Return a name and its skeleton, both folded; they may differ: Ι folds to ι, and looks like l.

    Cached, since each new name is compared with everybody's: some characters expand to 18.
    """
    return frozenset({_folded(name), _folded(skeleton(name))})


def _folded(name: str) -> str:
    """Return a name without case, accents, width, spaces and punctuation (UAX 15)."""
    plain = unicodedata.normalize("NFKD", name).casefold()
    return "".join(c for c in plain if unicodedata.category(c)[0] in "LN") or name


def _without_piles(name: str) -> str:
    kept, marks = [], 0
    for c in name:
        marks = marks + 1 if unicodedata.category(c)[0] == "M" else 0
        if marks <= _MAX_MARKS:
            kept.append(c)
    return "".join(kept)


_RESERVED: Final = frozenset[str]().union(
    *(_looks(article + title) for article in ("", "the") for title in _TITLES)
)
