"""A board's log, as a test imagines it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from e2e.stop.record import Record


def record(*events: dict[str, Any]) -> Record:
    found = Record(Path("unread"))
    found.take(events)
    return found
