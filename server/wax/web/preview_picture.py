"""The picture for link previews, read and checked once at the start."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np

from wax.errors import ConfigError
from wax.folders import expanded
from wax.named_file import check, problem, read_bytes

MAX_BYTES: Final = 1 << 20
"""Most sites leave a larger one out of previews, and the others load it slowly."""

_KEY: Final = "page.picture"
_TYPES: Final = {
    b"\x89PNG\r\n\x1a\n": "image/png",
    b"\xff\xd8\xff": "image/jpeg",
}


@dataclass(frozen=True, slots=True)
class PreviewPicture:
    """A valid picture; `digest` changes with its content."""

    content: bytes
    content_type: str
    width: int
    height: int

    @property
    def digest(self) -> str:
        return hashlib.sha256(self.content).hexdigest()[:16]


def read(name: str) -> PreviewPicture | None:
    """Return the picture in this file, None for no name; raises `ConfigError`, with a sentence."""
    if not name:
        return None
    path = expanded(name)
    try:
        size = check(path).st_size
        content = read_bytes(path, MAX_BYTES) if size <= MAX_BYTES else b""
    except OSError as error:
        raise ConfigError(
            f"{_KEY}: {name} {problem(error)} (looked for {path.absolute()}); name a PNG, JPEG or"
            " WebP picture, or leave the key out"
        ) from error
    if size > MAX_BYTES:
        raise ConfigError(
            f"{_KEY}: {name} has {size / MAX_BYTES:.1f} MiB, and 1 MiB is the most; make it"
            " smaller: 1200 pixels by 630 are what previews show"
        )
    content_type = _type_of(content)
    decoded = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR) if content else None
    if content_type is None or decoded is None:
        raise ConfigError(f"{_KEY}: {name} is no PNG, JPEG or WebP picture, or a damaged one")
    height, width = decoded.shape[:2]
    return PreviewPicture(content, content_type, width, height)


def _type_of(content: bytes) -> str | None:
    if content[:4] == b"RIFF" and content[8:12] == b"WEBP":
        return "image/webp"
    return next((kind for magic, kind in _TYPES.items() if content.startswith(magic)), None)
