"""What both exports read of a part of the tape: its events, and which files its cameras have."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.errors import StateError
from wax.protocol.tape_events import Filmed
from wax.tape.reading import read_events

if TYPE_CHECKING:
    from pathlib import Path

    from wax.tape.reading import Events
    from wax.tape.shelf import Shelved

DRIVING_VIEW: Final = "driving_view"
"""The name of the picture by which operators drive."""


def events_of(part: Shelved) -> Events:
    """Read a part's events; raises `StateError` with the reason if there are none."""
    if part.events is None:
        raise StateError(f"{part.name}: its events are missing, so nothing says what was driven")
    return read_events(part.events)


def cameras_of(part: Shelved, events: Events) -> dict[str, tuple[Path | None, float]]:
    """Return each camera's file, None if it is missing, and its time 0 in seconds since 1970."""
    found = {DRIVING_VIEW: (part.media, events.began_s)}
    for at_s, event in events.timed:
        if isinstance(event, Filmed):
            found[event.name] = part.cameras.get(event.camera), at_s
    return found
