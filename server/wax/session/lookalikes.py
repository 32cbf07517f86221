"""Which texts look alike, by the skeletons of Unicode's security mechanisms (UTS 39, 4). Pure."""

from __future__ import annotations

import json
import unicodedata
from importlib import resources
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Mapping

_LEFT_TO_RIGHT: Final = "\u200e"
"""The data file puts this mark around right-to-left text."""


def skeleton(text: str) -> str:
    """Return a text's skeleton: texts that look alike have the same one."""
    plain = unicodedata.normalize("NFKD", text)
    alike = "".join(_PROTOTYPES.get(character, character) for character in plain)
    return unicodedata.normalize("NFKD", alike)


def _prototypes() -> dict[str, str]:
    """Return each character's prototype, which stands for all that look like it.

    The data file lists a prototype's many lookalikes, and for any other character its prototype
    alone. Of two that list only each other, the lower one is the prototype.
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
"""Read on import: it takes some 40 ms, which would hold up the control loop."""
