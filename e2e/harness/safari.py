"""A Chromium shaped like Safari, by the compatibility data that browser makers maintain."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from e2e.measure.suite import ROOT

if TYPE_CHECKING:
    from collections.abc import Iterator

_SCRIPT: Final = Path(__file__).with_suffix(".js")
_DATA: Final = ROOT / "web/node_modules/@mdn/browser-compat-data/data.json"
_NAME: Final = re.compile(r"\w+")
_ALSO: Final = (("RTCRtpReceiver", "playoutDelayHint"), ("Navigator", "wakeLock"))
"""APIs of Chromium alone, and what a page on the home screen lacks."""


def shaped_like(version: float) -> str:
    """Return the script that turns a page's browser into the Safari of this version of iOS.

    An API that Safari has in at least one place stays everywhere; workers keep all APIs.
    """
    data = json.loads(_DATA.read_text(encoding="utf-8"))
    parts = {**data["javascript"]["builtins"], **data["api"]}
    lacked = json.dumps([*_lacked(parts, version), *_ALSO])
    return _SCRIPT.read_text(encoding="utf-8").replace("})(LACKED)", f"}})({lacked})")


def _lacked(parts: dict[str, Any], version: float) -> Iterator[tuple[str, str | None]]:
    for owner, entry in parts.items():
        if owner != "Window" and not _has(entry, version):
            yield owner, None
            continue
        for name, member in entry.items():
            if name != owner and _NAME.fullmatch(name) and not _has(member, version):
                yield owner, name


def _has(entry: dict[str, Any], version: float) -> bool:
    support = entry.get("__compat", {}).get("support", {}).get("safari_ios", [])
    if not support:
        return True  # there is no data about it
    statements = support if isinstance(support, list) else [support]
    return any(_holds(one, version) for one in statements)


def _holds(one: dict[str, Any], version: float) -> bool:
    if one.keys() & {"flags", "prefix", "alternative_name"}:
        return False
    return _number(one["version_added"]) <= version < _number(one.get("version_removed", False))


def _number(version: str | bool | None) -> float:
    """Return a version as a number; never, or not yet, is infinite."""
    if not isinstance(version, str) or version == "preview":
        return float("inf")
    return float(version.removeprefix("≤"))
