"""The problems of a configuration, one sentence for each key."""

from __future__ import annotations

import re
from difflib import get_close_matches
from typing import TYPE_CHECKING, Final

from wax.config import allowed

if TYPE_CHECKING:
    from collections.abc import Iterable

    from pydantic import ValidationError
    from pydantic_core import ErrorDetails

_RENAMED: Final = {
    "video.imprint": "video.timestamp_overlay",
    "audio.forms": "audio.encodings",
    "drive.fine_fraction": "drive.slow_fraction",
    "sync.operator.own_rendition": "sync.operator.finer_ladder",
    "sync.observer.own_rendition": "sync.observer.finer_ladder",
}
"""The old names of renamed keys, each with the new one."""

_REMOVED: Final = {
    "ice": "is gone, since its passwords were shown to every visitor; list STUN servers in"
    " network.stun, and name a TURN server with its static-auth-secret in [relay]",
    **dict.fromkeys(
        ("video.retry_s", "camera.retry_s", "audio.retry_s", "voice.retry_s"),
        "is gone; delete it: what has failed is opened again after a second",
    ),
}
"""Removed keys, each with what to write instead."""


def lines(error: ValidationError, schema: allowed.Schema, table: str = "") -> list[str]:
    """Return a sentence for each wrong key; `table` is the one that `schema` describes."""
    # pydantic reports a problem for each branch of a union; one line for the key is enough.
    told = [one for one in error.errors() if one["type"] != "default_factory_not_called"]
    return list(dict.fromkeys(_sentence(problem, schema, table) for problem in told))


def unknown(key: str, neighbours: Iterable[str]) -> str:
    """Return the sentence for an unknown key, with the one that may be meant."""
    near = get_close_matches(key.rpartition(".")[2], list(neighbours))
    return f"{key}: there is no such key" + (f"; did you mean {near[0]}?" if near else "")


def _sentence(problem: ErrorDetails, schema: allowed.Schema, table: str) -> str:
    inner, known = allowed.find(schema, problem["loc"])
    key = ".".join(part for part in (table, inner) if part)
    if key in _RENAMED:
        return f"{key}: is now called {_RENAMED[key]}"
    if (removed := _REMOVED.get(re.sub(r"\[\d+\]", "", key))) is not None:
        return f"{key}: {removed}"
    if known is None:
        return unknown(key, allowed.neighbours(schema, problem["loc"]))
    if problem["type"] == "missing":
        return f"{key}: is missing; allowed is {allowed.words(known)}"
    if problem["type"] == "value_error":
        sentence = problem["msg"].removeprefix("Value error, ")
        return f"{key}: {sentence}" if key else sentence
    return f"{key}: got {allowed.shown(problem['input'])}; allowed is {allowed.words(known)}"
