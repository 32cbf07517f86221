"""Names as people write them, made valid for topics and ids. Pure."""

from __future__ import annotations

import hashlib
import re
import unicodedata
from typing import Final

_MOST: Final = 40
_FITS: Final = re.compile(r"[A-Za-z0-9 _/-]{1,40}")


def slug(text: str) -> str:
    """Return 1 to 49 lower-case letters, digits and underscores, the same for the same text.

    A digest keeps two names apart where more than case and separators is lost.
    """
    plain = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode().lower()
    kept = re.sub(r"[^a-z0-9]+", "_", plain).strip("_")[:_MOST].strip("_")
    if kept and _FITS.fullmatch(text):
        return kept
    digest = hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()[:8]
    return f"{kept}_{digest}".strip("_")


def client_id(topic: str, use: str) -> str:
    """Return the client id of a robot's connection for one use, the same for the same topic.

    It has at most 23 letters and digits, which every broker accepts (MQTT 5, 3.1.3.1).
    """
    plain = re.sub(r"[^a-z0-9]", "", slug(topic))[:15]
    return plain + hashlib.sha256(f"{use} {topic}".encode()).hexdigest()[:8]
