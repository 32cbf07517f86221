"""The folder of the tape: each part is a media file, an events file and perhaps a mark.

Cameras other than the driving view have media files of their own: ``NAME.camera-1.webm`` etc.

One mark says that the part is kept, and by whom, another that its operator wants nothing of a time
to be used. File names contain the time at which the part began, so that they sort by it.
"""

from __future__ import annotations

import math
import os
import re
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime
from itertools import zip_longest
from typing import TYPE_CHECKING, Final, Literal, get_args

from wax import state_dir
from wax.config.camera import MAX_CAMERAS
from wax.errors import StateError, reason_of
from wax.tape.retention import Keeper, Part

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from wax.config.recording import RecordingSettings

FOLDER: Final = "tape"
EVENTS: Final = ".mcap"
MEDIA: Final = (".webm", ".mp4")
_KEPT: Final = ".kept"
_DISOWNED: Final = ".disowned"
_CAMERA: Final = ".camera-"


def camera_ending(camera: int, ending: str) -> str:
    """Return the ending of a camera's media file; cameras count from 1."""
    return f"{_CAMERA}{camera}{ending}"


CAMERAS: Final = {
    camera_ending(camera, ending): camera
    for camera in range(1, MAX_CAMERAS + 1)
    for ending in MEDIA
}
"""The camera of each ending of a camera's media file."""
_ENDINGS: Final = (_DISOWNED, *CAMERAS, *MEDIA, EVENTS, _KEPT)
"""Longer endings precede their own suffixes. They are deleted from the last to the first."""
_NAME: Final = re.compile(r"wax-(\d{8}T\d{6})Z(-\d{1,3})?")
_TIME: Final = "%Y%m%dT%H%M%S"
_MOST_IN_A_SECOND: Final = 1000
_OVERLAP_S: Final = 2.0
"""A name has whole seconds, and a part may end a moment after the next one's first picture."""


def unfinished_path(path: Path) -> Path:
    """Return the path at which a file's replacement is written; it belongs to no part."""
    return path.with_name(f"{path.name}.unready")


def ending_of(file: str) -> str:
    """Return the ending that says which of a part's files this is; "" if it is not ours."""
    return next((one for one in _ENDINGS if file.endswith(one)), "")


@dataclass(frozen=True, slots=True)
class Shelved:
    """One part in the folder; times are in seconds since 1970."""

    name: str
    began_s: float
    ended_s: float
    size_bytes: int
    kept: Keeper | None
    media: Path | None
    events: Path | None
    cameras: dict[int, Path] = field(default_factory=dict)
    """The files of the cameras other than the driving view, which count from 1."""
    disowned: tuple[tuple[float, float], ...] = ()
    """Times of which their operators want nothing to be used."""

    def is_disowned(self, at_s: float) -> bool:
        """Return whether its operator wants nothing of this time to be used."""
        return any(begin_s <= at_s <= end_s for begin_s, end_s in self.disowned)

    def as_part(self, open_name: str | None = None) -> Part:
        """Return the part for retention; `open_name` is the part that is being written."""
        return Part(self.name, self.ended_s, self.size_bytes, self.kept, self.name == open_name)


def where(settings: RecordingSettings, state: str) -> Path:
    """Return the tape's folder, which need not exist; `state` is the configured state folder.

    Raises `StateError`.
    """
    if settings.folder:
        return state_dir.find(settings.folder)
    return state_dir.find(state) / FOLDER


class Shelf:
    """The tape's folder, which the server and `wax tape` may use at the same time."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def prepare(self) -> None:
        """Create the folder for its owner only; raises `StateError` with what to do."""
        try:
            self.folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        except OSError as error:
            raise self._unusable(reason_of(error)) from error
        if not os.access(self.folder, os.R_OK | os.W_OK | os.X_OK):
            raise self._unusable("this user may not write there")

    def parts(self) -> list[Shelved]:
        """Return all parts, the oldest first; raises `StateError`."""
        found: dict[str, list[str]] = {}
        try:
            with os.scandir(self.folder) as entries:
                for entry in entries:
                    ending = ending_of(entry.name)
                    name = entry.name.removesuffix(ending)
                    if ending and _NAME.fullmatch(name):
                        found.setdefault(name, []).append(ending)
        except FileNotFoundError:
            return []
        except OSError as error:
            raise self._unusable(reason_of(error)) from error
        parts = (self._part(name, endings) for name, endings in sorted(found.items()))
        return [one for one in parts if one is not None]

    def part(self, name: str) -> Shelved | None:
        """Return one part without reading the others; None if there is none of that name."""
        if not _NAME.fullmatch(name):
            return None
        endings = [ending for ending in _ENDINGS if (self.folder / (name + ending)).exists()]
        return self._part(name, endings) if endings else None

    def new_name(self, wall_ms: float) -> str:
        """Return an unused name for a part that begins at this time."""
        began = datetime.fromtimestamp(wall_ms / 1000, UTC)
        base = f"wax-{began:{_TIME}}Z"
        for number in range(_MOST_IN_A_SECOND):
            name = f"{base}-{number}" if number else base
            if not any((self.folder / (name + ending)).exists() for ending in _ENDINGS):
                return name
        raise StateError(f"{self.folder}: there are {_MOST_IN_A_SECOND} parts called {base}")

    def path(self, name: str, ending: str) -> Path:
        """Return the path of one of a part's files; raises `StateError` for what is no name."""
        if not _NAME.fullmatch(name):
            raise StateError(f"{name!r} is no part of the tape; `wax tape list` shows their names")
        return self.folder / (name + ending)

    def keep(self, name: str, by: Keeper) -> None:
        """Mark a part as kept; the host's mark replaces the others'. Raises `OSError`."""
        mark = self.path(name, _KEPT)
        if self._kept(mark) != "host":
            self._mark(mark, by, "w")

    def disown(self, begin_s: float, end_s: float) -> None:
        """Mark that nothing of this time is to be used, in all parts that may have something of it.

        Raises `OSError` or `StateError`.
        """
        parts = self.parts()
        for part, after in zip_longest(parts, parts[1:]):
            ended_s = math.inf if after is None else after.began_s + _OVERLAP_S
            if part.began_s <= end_s and begin_s <= ended_s:
                self._mark(self.path(part.name, _DISOWNED), f"{begin_s} {end_s}\n", "a")

    def delete(self, name: str) -> None:
        """Delete a part with all its files; safe to call twice. Raises `OSError`."""
        # The events go before the media: a repair of the media checks whether the events exist.
        for ending in reversed(_ENDINGS):
            path = self.path(name, ending)
            path.unlink(missing_ok=True)
            unfinished_path(path).unlink(missing_ok=True)

    def _part(self, name: str, endings: Sequence[str]) -> Shelved | None:
        files = {ending: self.folder / (name + ending) for ending in endings}
        size = 0
        try:
            began = datetime.strptime(name[4:19], _TIME).replace(tzinfo=UTC).timestamp()
            ended_s = began
            for ending, path in files.items():
                status = path.stat()
                size += status.st_size
                if ending not in (_KEPT, _DISOWNED):
                    ended_s = max(ended_s, status.st_mtime)
        except (OSError, ValueError):
            return None  # deleted meanwhile, or not our name: it has a month 13
        return Shelved(
            name=name,
            began_s=began,
            ended_s=ended_s,
            size_bytes=size,
            kept=self._kept(files[_KEPT]) if _KEPT in files else None,
            media=next((files[one] for one in MEDIA if one in files), None),
            events=files.get(EVENTS),
            cameras={CAMERAS[one]: files[one] for one in files if one in CAMERAS},
            disowned=_disowned(files[_DISOWNED]) if _DISOWNED in files else (),
        )

    def _mark(self, mark: Path, text: str, mode: Literal["w", "a"]) -> None:
        state_dir.make_private(mark)
        with mark.open(mode, encoding="ascii") as file:
            file.write(text)
        state_dir.sync(mark)
        state_dir.sync(self.folder)

    def _kept(self, mark: Path) -> Keeper | None:
        """Return who keeps a part; an unreadable mark counts as the host's."""
        with suppress(FileNotFoundError):
            try:
                text = mark.read_text(encoding="ascii").strip()
            except (OSError, UnicodeDecodeError) as error:
                if isinstance(error, FileNotFoundError):
                    raise
                return "host"
            return next((one for one in get_args(Keeper) if one == text), "host")
        return None

    def _unusable(self, why: str) -> StateError:
        return StateError(f"{self.folder}: {why}; name another folder with [recording] folder")


def _disowned(mark: Path) -> tuple[tuple[float, float], ...]:
    """Return the times in a mark; an unreadable one counts for all times."""
    try:
        lines = [line.split() for line in mark.read_text(encoding="ascii").splitlines()]
        return tuple((float(begin), float(end)) for begin, end in lines)
    except (OSError, ValueError):
        return ((-math.inf, math.inf),)
