"""Reports what happens in the room to the records and `event_maker`; contains its own errors."""

from __future__ import annotations

import asyncio
import math
import re
from collections import Counter
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Final, Literal

from wax.control.listener import Listener
from wax.control.reasons import NOBODY_DRIVES, NOT_HELD, Hold, Limit, Refusal
from wax.control.turns import TurnEnded, TurnStarted
from wax.error_boundary import FirstErrorLogged
from wax.fanout.batches import in_batches
from wax.protocol.events import StopEvent, StoppedByItself
from wax.records.entries import NOBODY, RecordedPerson
from wax.session.link_statistics import LinkStatistics
from wax.session.turn_thrift import TurnThrift

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from wax.clock import Clock
    from wax.control.turns import TurnEvent
    from wax.protocol.events import StopRole
    from wax.records.records import Records
    from wax.sentence import Sentence
    from wax.session.event_maker import EventMaker
    from wax.session.viewer import Viewer


DriveStatus = tuple[int, bool, "Sentence | None"]
"""The operator, whether the robot moves, and what holds it back; see `Listener`."""

_POLL_S: Final = 1.0
_UPDATE_S: Final = 60.0
"""A crash may lose this much of a visit's figures; more writes would wear out an SD card."""
_STOP_GAP_S: Final = 1.0
"""On a bad link the robot stops again and again; that is one row a second at most."""

_LEFT_OUT: Final = "turns over the rate"
PRESSED: Final = "pressed"
ROBOT: Final = "robot"
_REFUSED: Final = re.compile("refused|over the rate")
_NAMES: Final[dict[str, str]] = {
    NOBODY_DRIVES.code: "nobody_drives",
    NOT_HELD.code: "not_held",
    **{one.value.code: one.name.lower() for one in (*Refusal, *Hold, *Limit)},
}
_NO_STOP: Final = {
    NOBODY_DRIVES.code,
    NOT_HELD.code,
    Hold.TURN_STARTED.value.code,
    Hold.STOPPED.value.code,
    *(one.value.code for one in Limit),
}
"""Reasons that do not count as an involuntary stop."""


@dataclass
class _Visit:
    viewer: Viewer
    number: int
    link: LinkStatistics = field(default_factory=LinkStatistics)


class RecordKeeper(Listener):
    """Polls the viewers once a second, and is called about turns and Stops.

    `refused` returns counts that only rise, by reason. No method raises.
    """

    def __init__(
        self,
        *,
        records: Records,
        clock: Clock,
        viewers: Iterable[Viewer],
        refused: Callable[[], Mapping[str, float]],
        event_maker: EventMaker,
    ) -> None:
        self.event_maker = event_maker
        self._records = records
        self._clock = clock
        self._viewers = viewers
        self._refused = refused
        self._refused_before: Mapping[str, float] = {}
        self._visits: dict[int, _Visit] = {}
        self._turns: dict[int, int] = {}  # the records' numbers, by the turns' own
        self._stop: int | None = None
        self._drive_status: DriveStatus | None = None
        self._stop_written_s = -math.inf
        self._updated_s = clock.now_s()
        self._thrift = TurnThrift()
        self._contained = FirstErrorLogged("the records are incomplete")
        """Wraps all work here: a failing record must never stop the robot."""
        self.stops: Counter[str] = Counter()
        """Stops by reason, since the start."""

    async def run(self) -> None:
        """Poll until cancelled."""
        while True:
            self.poll()
            await asyncio.sleep(_POLL_S)

    def poll(self) -> None:
        """Record who came and went, and how their links are."""
        with self._contained:
            self._turn_began(self._thrift.due(self._clock.now_s()))
            present = {viewer.number: viewer for viewer in self._viewers if viewer.was_ready}
            gone = self._visits.keys() - present.keys()
            went = (partial(self._end_visit, number) for number in gone)
            here = (partial(self._sample, viewer) for viewer in present.values())
            in_batches([*went, *here])
            if self._clock.now_s() - self._updated_s >= _UPDATE_S:
                self._update_all()
        self.event_maker.poll()

    def close(self) -> None:
        """End the running turns and visits, because the server ends."""
        with self._contained:
            for turn in list(self._turns):
                self._records.turn_ended(self._turns.pop(turn), "server stopped")
            for number in list(self._visits):
                self._end_visit(number)
            self._update_all()
        self.event_maker.close()

    # --- turns and stops ---------------------------------------------------------------------

    def turn_events(self, events: tuple[TurnEvent, ...]) -> None:
        with self._contained:
            for event in events:
                if isinstance(event, TurnStarted):
                    is_told = self._thrift.began(event, self._clock.now_s())
                    self._turn_began(event if is_told else None)
                elif isinstance(event, TurnEnded):
                    self._thrift.ended()
                    if event.number in self._turns:
                        self._records.turn_ended(self._turns.pop(event.number), event.why.value)
                        self.event_maker.turn_ended(event.why)

    def _turn_began(self, turn: TurnStarted | None) -> None:
        if turn is not None:
            person = self._person(turn.operator)
            self._turns[turn.number] = self._records.turn_began(turn.number, person)
            self.event_maker.turn_began(turn.number, turn.operator, person.name)

    def stop_pressed(self, viewer: Viewer | None, name: str, stop: int, role: StopRole) -> None:
        """Record a pressed Stop; `viewer` is None for somebody without a page."""
        with self._contained:
            self.stops[PRESSED] += 1
            if self._stop is None:
                person = RecordedPerson("", name) if viewer is None else _person_of(viewer)
                self._stop = self._records.stop_pressed(stop, person, PRESSED)
                self.event_maker.publish(_stop_event("stop.pressed", viewer, stop, role))

    def stop_released(self, viewer: Viewer | None, name: str, stop: int, role: StopRole) -> None:
        with self._contained:
            if self._stop is not None:
                self._records.stop_released(self._stop, name)
                self._stop = None
                self.event_maker.publish(_stop_event("stop.released", viewer, stop, role))

    def drive_status(
        self, number: int, moving: bool, reason: Sentence | None, _share: float
    ) -> None:
        """Record when and why the robot stops by itself; see `Listener`."""
        with self._contained:
            self._turn_began(self._thrift.due(self._clock.now_s(), is_driven=moving))
            before, self._drive_status = self._drive_status, (number, moving, reason)
            why = why_stopped(before, self._drive_status)
            if why is None or self._stop is not None:
                return
            self.stops[why] += 1
            now_s = self._clock.now_s()
            if now_s - self._stop_written_s >= _STOP_GAP_S:
                self._stop_written_s = now_s
                told = f"{why}: {reason}" if why == ROBOT else why.replace("_", " ")
                person = self._person(number)
                self._records.stop_pressed(None, person, told)
                self.event_maker.publish(StoppedByItself(viewer=number, why=why, name=person.name))

    # --- visits ------------------------------------------------------------------------------

    def _sample(self, viewer: Viewer) -> None:
        with self._contained, viewer.boundary:
            visit = self._visits.get(viewer.number)
            if visit is None:
                number = self._records.session_began(
                    _person_of(viewer), address=viewer.visitor.address, role=_role(viewer)
                )
                visit = self._visits[viewer.number] = _Visit(viewer, number)
            if viewer.is_ready:
                visit.link.sample(viewer)

    def _end_visit(self, number: int) -> None:
        with self._contained:
            if (visit := self._visits.pop(number, None)) is not None:
                self._write_visit(visit, is_over=True)

    def _update_visit(self, visit: _Visit) -> None:
        """Update a visit, unless it has ended since the update was scheduled."""
        with self._contained:
            if self._visits.get(visit.viewer.number) is visit:
                self._write_visit(visit)

    def _write_visit(self, visit: _Visit, *, is_over: bool = False) -> None:
        viewer = visit.viewer
        self._records.session_seen(
            visit.number, _person_of(viewer), _role(viewer), visit.link.summary(), is_over=is_over
        )

    def _update_all(self) -> None:
        self._updated_s = self._clock.now_s()
        in_batches([partial(self._update_visit, visit) for visit in self._visits.values()])
        before = self._refused_before
        self._refused_before = {**self._refused(), _LEFT_OUT: self._thrift.left_out}
        grown = {
            reason: int(count - before.get(reason, 0))
            for reason, count in self._refused_before.items()
        }
        self._records.refused({reason: count for reason, count in grown.items() if count > 0})

    def _person(self, number: int) -> RecordedPerson:
        viewer = next((one for one in self._viewers if one.number == number), None)
        return NOBODY if viewer is None else _person_of(viewer)


def why_stopped(before: DriveStatus | None, now: DriveStatus) -> str | None:
    """Return the short name of the reason that has just stopped or held the moving robot.

    None if none has, or the operator wanted it. A pressed Stop counts as the robot's own reason,
    `ROBOT`: callers have to recognise it themselves.
    """
    number, _, reason = now
    if before is None or before[0] != number or not before[1] or before[2] == reason:
        return None
    if reason is None or reason.code in _NO_STOP:
        return None
    return name_of(reason)


def name_of(reason: Sentence) -> str:
    """Return the short name of one of the gate's sentences, `ROBOT` for the robot's own."""
    return _NAMES.get(reason.code, ROBOT)


def refused(counts: Mapping[str, float]) -> dict[str, float]:
    """Return the server's counts of refusals."""
    return {name: count for name, count in counts.items() if _REFUSED.search(name)}


def _person_of(viewer: Viewer) -> RecordedPerson:
    return RecordedPerson(viewer.visitor.identity, viewer.name)


def _stop_event(
    kind: Literal["stop.pressed", "stop.released"], viewer: Viewer | None, stop: int, role: StopRole
) -> StopEvent:
    name = None if viewer is None else viewer.name
    return StopEvent(type=kind, stop=stop, role=role, name=name)


def _role(viewer: Viewer) -> str:
    return "host" if viewer.visitor.is_host else "guest"
