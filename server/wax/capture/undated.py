"""Explains why a source whose pictures are of unknown age cannot be driven by, and what to do."""

from __future__ import annotations

from urllib.parse import urlsplit

from wax.capture.file.address import is_network, shown_name
from wax.plugin import CAMERAS, is_plugin
from wax.sentence import Sentence


def undated(source: str) -> Sentence:
    """Return the sentence for the host about this value of `[video] source`."""
    if is_network(source):
        name = shown_name(source)
        if urlsplit(source).scheme in ("http", "https"):
            return Sentence("camera.undated", {"name": name})
        return Sentence("camera.undated_stream", {"name": name})
    if source in ("auto", "robot"):
        return Sentence("camera.undated_robot")
    if is_plugin(source, CAMERAS, "[video] source"):
        return Sentence("camera.undated_plugin", {"name": source})
    return Sentence("camera.undated", {"name": source})
