"""Reads all that an export needs to know of a tape before it writes: its episodes and values."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from wax.dataset.episodes import QUIET_S, EpisodeFinder, LeftOut
from wax.dataset.frames import ACTIONS, named, told
from wax.dataset.parts import DRIVING_VIEW, cameras_of, events_of, pictures_of
from wax.errors import StateError, reason_of
from wax.protocol.tape_events import Commanded, Reported, Steered
from wax.tape.event_ending import ending_of
from wax.tape.reading import read_events
from wax.tape.repaired import facts_of

if TYPE_CHECKING:
    from pathlib import Path

    from wax.dataset.episodes import Episode
    from wax.dataset.pictures import PictureFile
    from wax.protocol.tape_events import TapeEvent
    from wax.tape.reading import Events
    from wax.tape.selection import Selection
    from wax.tape.shelf import Shelved

_KINDS: Final = (Commanded, Reported, Steered)
_OPEN: Final = "is still being written; export it once the next part begins, or the server ends"
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
            for at_s, event in read_events(part.events).timed
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
            events = events_of(part)
            finder.begin_part(events.began_s)
            for at_s, event in events.timed:
                finder.add(at_s, event)
            found.parts.append(_survey(part, events, camera, cameras))
            for _, event in events.timed:
                seen.add(event)
            if events.problem is not None:
                why = f"{part.name}: {events.problem}"
                found.left_out.append(LeftOut(events.ended_s, events.ended_s, why))
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


def _survey(part: Shelved, events: Events, camera: str, cameras: set[str]) -> SurveyedPart:
    """Return what a part has to export; raises `StateError` with the reason if nothing can."""
    assert part.events is not None
    try:
        if ending_of(part.events) == "open":
            raise StateError(f"{part.name}: {_OPEN}")
    except OSError as error:
        raise StateError(f"{part.name}: {reason_of(error)}") from error
    files = cameras_of(part, events)
    cameras.update(files)
    media = pictures_of(part, camera, *files.get(camera, (None, events.began_s)))
    sound = part.media if part.media is not None and facts_of(part.media).has_sound else None
    return SurveyedPart(part.events, events.began_s, events.ended_s + QUIET_S, media, sound)
