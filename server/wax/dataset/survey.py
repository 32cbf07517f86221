"""Reads all that an export needs to know of a tape before it writes: its episodes and values."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import av

from wax.dataset.episodes import QUIET_S, EpisodeFinder, LeftOut
from wax.dataset.frames import ACTIONS, named, told
from wax.dataset.pictures import picture_file
from wax.errors import StateError, reason_of
from wax.protocol.tape_events import Commanded, Filmed, Reported, Steered
from wax.tape.event_ending import ending_of
from wax.tape.reading import read_events
from wax.tape.repaired import facts_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from wax.dataset.episodes import Episode
    from wax.dataset.pictures import PictureFile
    from wax.protocol.tape_events import Placed, TapeEvent
    from wax.tape.selection import Selection
    from wax.tape.shelf import Shelved

DRIVING_VIEW: Final = "driving_view"
"""The name of the picture by which operators drive."""
_KINDS: Final = (Commanded, Reported, Steered)
_NO_EVENTS: Final = "nothing says what was driven"
_OPEN: Final = "is being written; it is whole when the next part begins"
_NO_PICTURE: Final = "has no picture of this camera"
_DISOWNED: Final = "its operator does not want it to be used"


@dataclass(frozen=True, slots=True)
class SurveyedPart:
    """A part that can be exported; it has ended by `ended_s`, in seconds since 1970.

    `sound` is the file with its sound, None if it has none.
    """

    events: Path
    began_s: float
    ended_s: float
    media: PictureFile
    sound: Path | None


@dataclass(slots=True)
class Survey:
    """What there is to export.

    `observed` are the values that the robot reported throughout, `actions` those that it was sent.
    """

    parts: list[SurveyedPart] = field(default_factory=list)
    episodes: list[Episode] = field(default_factory=list)
    left_out: list[LeftOut] = field(default_factory=list)
    actions: tuple[str, ...] = ()
    observed: tuple[str, ...] = ()

    def within(self, begin_s: float, end_s: float) -> list[SurveyedPart]:
        """Return the parts that have something of this time."""
        return [one for one in self.parts if one.began_s < end_s and one.ended_s >= begin_s]

    def events(self, begin_s: float, end_s: float) -> list[tuple[float, TapeEvent]]:
        """Return what was asked, sent and reported around this time; raises `StateError`.

        What a part repeats at its beginning is left out: it is newer than its time says.
        """
        found = [
            (at_s, event)
            for part in self.within(begin_s, end_s)
            for at_s, event in _placed(part.began_s, read_events(part.events).events)
            if isinstance(event, _KINDS) and at_s > part.began_s
        ]
        return sorted(found, key=lambda one: one[0])


def survey(selection: Selection, *, camera: str = DRIVING_VIEW, joins: bool = False) -> Survey:
    """Read the events of the selected parts; raises `StateError` if there is no such camera."""
    found = Survey()
    finder = EpisodeFinder(joins=joins)
    seen = _Values()
    cameras: set[str] = {DRIVING_VIEW}
    for part in selection.parts:
        try:
            read = _read(part, finder)
            found.parts.append(_survey(part, read, camera, cameras))
            for _, event in read.placed:
                seen.add(event)
            if read.problem is not None:
                why = f"{part.name}: {read.problem}"
                found.left_out.append(LeftOut(read.ended_s, read.ended_s, why))
        except StateError as error:
            found.left_out.append(LeftOut(part.began_s, part.ended_s, str(error)))
    if camera not in cameras:
        known = ", ".join(sorted(cameras))
        raise StateError(f"--camera: the tape has no {camera!r}; it has {known}")
    division = finder.finish()
    found.left_out += division.left_out
    for one in division.episodes:
        clipped = one.within(selection.begin_s, selection.end_s)
        if clipped is None or not found.within(clipped.begin_s, clipped.end_s):
            continue
        middle_s = (clipped.begin_s + clipped.end_s) / 2
        if any(part.is_disowned(middle_s) for part in selection.parts):
            found.left_out.append(LeftOut(clipped.begin_s, clipped.end_s, _DISOWNED))
        else:
            found.episodes.append(clipped)
    found.actions, found.observed = seen.actions, seen.observed
    return found


class _Values:
    """Which values the events have."""

    def __init__(self) -> None:
        self._sideways = False
        self._named: set[str] = set()
        self._told: dict[str, float] | None = None

    def add(self, event: TapeEvent) -> None:
        match event:
            case Steered():
                self._sideways = self._sideways or event.lateral_mps != 0
                self._named.update(named(event))
            case Reported() if event.connected:
                values = told(event)
                before = values if self._told is None else self._told
                self._told = {name: before[name] for name in before if name in values}

    @property
    def actions(self) -> tuple[str, ...]:
        moves = ACTIONS if self._sideways else ACTIONS[:2]
        return (*moves, *sorted(self._named))

    @property
    def observed(self) -> tuple[str, ...]:
        return tuple(self._told or ())


@dataclass(frozen=True, slots=True)
class _Read:
    """The events of a part; `problem` is what could not be read."""

    path: Path
    began_s: float
    placed: list[tuple[float, TapeEvent]]
    problem: str | None

    @property
    def ended_s(self) -> float:
        """The time of the newest event."""
        return self.placed[-1][0] if self.placed else self.began_s


def _read(part: Shelved, finder: EpisodeFinder) -> _Read:
    """Read a part's events, which the finder gets, too; raises `StateError`."""
    if part.events is None:
        raise StateError(f"{part.name}: {_NO_EVENTS}")
    events = read_events(part.events)
    began_s = events.began_wall_ms / 1000
    read = _Read(part.events, began_s, list(_placed(began_s, events.events)), events.problem)
    finder.begin_part(began_s)
    for at_s, event in read.placed:
        finder.add(at_s, event)
    return read


def _survey(part: Shelved, read: _Read, camera: str, cameras: set[str]) -> SurveyedPart:
    """Return what a part has to export; raises `StateError` with the reason if nothing can."""
    try:
        if ending_of(read.path) == "open":
            raise StateError(f"{part.name}: {_OPEN}")
    except OSError as error:
        raise StateError(f"{part.name}: {reason_of(error)}") from error
    begins = {DRIVING_VIEW: (part.media, read.began_s)}
    for at_s, event in read.placed:
        if isinstance(event, Filmed):
            begins[event.name] = part.cameras.get(event.camera), at_s
    cameras.update(begins)
    path, origin_s = begins.get(camera, (None, read.began_s))
    media = None if path is None else _media(part.name, path, origin_s)
    if media is None:
        raise StateError(f"{part.name}: {_NO_PICTURE}")
    sound = part.media if part.media is not None and facts_of(part.media).has_sound else None
    return SurveyedPart(read.path, read.began_s, read.ended_s + QUIET_S, media, sound)


def _media(name: str, path: Path, origin_s: float) -> PictureFile | None:
    problem = facts_of(path).problem
    if problem is not None:
        raise StateError(f"{name}: {problem}")
    try:
        return picture_file(path, origin_s)
    except (av.FFmpegError, OSError) as error:
        raise StateError(f"{name}: {reason_of(error)}") from error


def _placed(began_s: float, events: Sequence[Placed]) -> Iterator[tuple[float, TapeEvent]]:
    return ((began_s + one.at_ms / 1000, one.event) for one in events)
