"""What both exports share: how they read a part of the tape, and what they say of a full disk."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.dataset.pictures import picture_file
from wax.errors import StateError, is_disk_full, reason_of
from wax.protocol.tape_events import Filmed
from wax.tape.reading import read_events

if TYPE_CHECKING:
    from pathlib import Path

    from wax.dataset.pictures import PictureFile
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


def pictures_of(part: Shelved, camera: str, path: Path | None, origin_s: float) -> PictureFile:
    """Return what a camera's file shows; raises `StateError` with the reason if it shows nothing.

    `path` and `origin_s` are as `cameras_of` has them.
    """
    file = None if path is None else picture_file(path, origin_s)
    if file is None:
        raise StateError(f"{part.name}: has no picture of {camera}")
    return file


def cannot_write(path: Path, error: Exception) -> StateError:
    """Return what to do about an error while an export was written."""
    if is_disk_full(error):
        return StateError(f"{path}: the disk is full; free some, and give the same command again")
    return StateError(f"{path}: cannot be written: {reason_of(error)}")
