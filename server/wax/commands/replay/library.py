"""What can be replayed: one part of a tape, or all parts in a folder."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Final

from wax import folders
from wax.commands.replay.cameras import cameras_of
from wax.errors import StateError
from wax.named_file import check, problem
from wax.protocol.tape_events import Placed, TapeContent, TapeListing, TapePart
from wax.tape.reading import read_events
from wax.tape.repaired import facts_of, repaired
from wax.tape.shelf import CAMERAS, EVENTS, MEDIA, Shelf, Shelved, ending_of

_NO_EVENTS: Final = "There are no events beside this: only picture and sound can be played."


class Library:
    """Safe to read from any thread; `close` deletes the copies that it had to make.

    `path` is a folder, or any file of a part. Raises `StateError` if there is nothing to replay.
    """

    def __init__(self, path: Path) -> None:
        self._only: Shelved | None = None
        if path.is_dir():
            self._shelf = Shelf(path)
        else:
            self._shelf, self._only = Shelf(path.parent), _alone(path)
        self._lock = threading.Lock()
        self._copies = folders.temporary("wax-replay-")
        try:
            self._check(path)
        except StateError:
            self.close()
            raise

    def _check(self, path: Path) -> None:
        parts = self._parts()
        if not parts:
            raise StateError(f"{path}: there is nothing of a tape in it")
        if self._only is not None:
            self.content(self._only.name)  # what is wrong with it is said now, not on the page

    def close(self) -> None:
        self._copies.cleanup()

    def listing(self) -> TapeListing:
        """Return all parts, the oldest first; raises `StateError`."""
        return TapeListing(
            parts=[
                TapePart(
                    name=one.name,
                    began_wall_ms=round(one.began_s * 1000),
                    size_bytes=one.size_bytes,
                    kept=one.kept,
                )
                for one in self._parts()
            ]
        )

    def content(self, name: str) -> TapeContent:
        """Return a part without picture and sound; raises `StateError`."""
        part = self._part(name)
        media = None if part.media is None else facts_of(part.media)
        began_wall_ms, length_ms = part.began_s * 1000, 0.0
        events: list[Placed] = []
        problem: str | None = _NO_EVENTS
        if part.events is not None:
            read = read_events(part.events)
            began_wall_ms, events, problem = read.began_wall_ms, read.events, read.problem
            length_ms = read.length_ms
        if media is not None:
            length_ms = max(length_ms, media.length_ms)
            problem = problem or media.problem
        cameras, unshown = cameras_of(part, events)
        return TapeContent(
            name=name,
            began_wall_ms=began_wall_ms,
            length_ms=length_ms,
            has_media=media is not None and (media.has_picture or media.has_sound),
            has_picture=media is not None and media.has_picture,
            has_sound=media is not None and media.has_sound,
            cameras=cameras,
            events=events,
            problem=problem or unshown,
        )

    def media(self, name: str, camera: int | None = None) -> Path:
        """Return a seekable file with picture and sound, or with those of a camera.

        Raises `StateError`.
        """
        part = self._part(name)
        path = part.media if camera is None else part.cameras.get(camera)
        if path is None:
            what = "no picture and sound" if camera is None else f"no pictures of camera {camera}"
            raise StateError(f"{name}: there are {what} beside these events")
        with self._lock:
            return repaired(path, Path(self._copies.name))

    def _parts(self) -> list[Shelved]:
        return self._shelf.parts() if self._only is None else [self._only]

    def _part(self, name: str) -> Shelved:
        only = self._only
        part = self._shelf.part(name) if only is None else only if only.name == name else None
        if part is None:
            raise StateError(f"{name}: is not on this tape, or was deleted meanwhile")
        return part


def _alone(path: Path) -> Shelved:
    """Return the part that a file belongs to, whatever it is called; raises `StateError`."""
    try:
        status = check(path)
    except OSError as error:
        raise StateError(
            f"{path} {problem(error)}; `wax tape list` shows what is recorded"
        ) from error
    ending = ending_of(path.name)
    if ending not in (EVENTS, *MEDIA, *CAMERAS):
        endings = ", ".join((EVENTS, *MEDIA))
        raise StateError(f"{path}: is no part of a tape; the files of those end in {endings}")
    name = path.name.removesuffix(ending)
    beside = {one: path.with_name(name + one) for one in (EVENTS, *MEDIA, *CAMERAS)}
    there = {one: file for one, file in beside.items() if file.is_file()}
    return Shelved(
        name=name,
        began_s=status.st_mtime,
        ended_s=status.st_mtime,
        size_bytes=status.st_size,
        kept=None,
        media=next((there[one] for one in MEDIA if one in there), None),
        events=there.get(EVENTS),
        cameras={CAMERAS[one]: file for one, file in there.items() if one in CAMERAS},
    )
