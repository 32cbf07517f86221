"""Which texts look alike, by the skeletons of Unicode's security mechanisms (UTS 39, 4). Pure."""

from __future__ import annotations

import json
import unicodedata
from importlib import resources
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Mapping

_LEFT_TO_RIGHT: Final = "\u200e"
"""The data have this mark around what is written from right to left."""


def skeleton(text: str) -> str:
    """Return what texts that look alike have in common, to compare them by."""
    plain = unicodedata.normalize("NFKD", text)
    alike = "".join(_PROTOTYPES.get(character, character) for character in plain)
    return unicodedata.normalize("NFKD", alike)


def _prototypes() -> dict[str, str]:
    """Return the one of those that look alike which stands for them, by each of the others.

    The data lists for each what looks like it: a prototype has many, any other its prototype alone.
    Of two that have only each other it is the lower one.
    """
    file = resources.files("confusable_homoglyphs") / "confusables.json"
    alike: Mapping[str, list[str]] = {
        text.strip(_LEFT_TO_RIGHT): [one["c"].strip(_LEFT_TO_RIGHT) for one in others]
        for text, others in json.loads(file.read_bytes()).items()
    }
    return {
        text: others[0] if len(alike.get(others[0], ())) > 1 else min(text, others[0])
        for text, others in alike.items()
        if len(text) == 1 and len(others) == 1
    }


_PROTOTYPES: Final = _prototypes()
"""Read with the module: it takes some 40 ms, for which the control loop would wait."""
