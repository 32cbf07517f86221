"""Makes text safe for logs and records: bounded, all of it visible, without secrets. Pure."""

from __future__ import annotations

import re
import unicodedata
from typing import Final

_HIDDEN: Final = frozenset({"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"})
"""Controls, bidirectional marks, surrogates, line separators and the like (UAX 44)."""

_LOGIN: Final = re.compile(r"//[^/]*@")


def printable(text: str, max_chars: int) -> str:
    """Return the text with hidden characters escaped as in Python, cut to `max_chars`."""
    cut = text[:max_chars]
    if not (cut.isascii() and cut.isprintable()):
        cut = "".join(_escaped(one) if _is_hidden(one) else one for one in cut)
    if len(text) <= max_chars and len(cut) <= max_chars:
        return cut
    return cut[: max(0, max_chars - 1)] + "…"


def shown_url(url: str) -> str:
    """Return an address without user name, password and query."""
    return re.split(r"[?#]", _LOGIN.sub("//", url), maxsplit=1)[0]


def _is_hidden(one: str) -> bool:
    return unicodedata.category(one) in _HIDDEN


def _escaped(one: str) -> str:
    return one.encode("unicode_escape").decode("ascii")
