"""Divides a tape into episodes: each is a turn, or a piece of one. Pure.

An episode ends with the turn, at a Stop or a fault, where the tape has a gap, and where the clock
was set back. After a Stop or fault the same turn goes on as another episode.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

from wax.protocol.tape_events import Faulted, Missed, Steered, Stopped, Tasked, Turned

if TYPE_CHECKING:
    from collections.abc import Iterable

    from wax.protocol.tape_events import TapeEvent

LONGEST_S: Final = 600.0
"""A turn that is renewed for hours is divided into episodes of this length."""
QUIET_S: Final = 2.0
"""The most time between the last event of a part and the next part, as set-points are repeated."""
_OVERLAP_S: Final = 1.0
"""A part begins with the capture of its first picture. What happened until that picture was encoded
is in the part before it."""

_STOPPED: Final = "Stop was pressed"
_FAULT: Final = "a fault stopped the robot"


@dataclass(frozen=True, slots=True)
class Episode:
    """A piece of the turn with this number, in seconds since 1970; `end_s` is no part of it."""

    turn: int
    begin_s: float
    end_s: float
    task: str = ""
    """What the operator said that they do; "" if they said nothing."""

    def within(self, begin_s: float, end_s: float) -> Episode | None:
        """Return what lies within a span of time; None if nothing does."""
        begin_s, end_s = max(begin_s, self.begin_s), min(end_s, self.end_s)
        return replace(self, begin_s=begin_s, end_s=end_s) if begin_s < end_s else None


@dataclass(frozen=True, slots=True)
class LeftOut:
    """A time that is in no episode, and why."""

    begin_s: float
    end_s: float
    why: str


@dataclass(slots=True)
class Division:
    """The episodes in order, and what was left out."""

    episodes: list[Episode] = field(default_factory=list)
    left_out: list[LeftOut] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class _State:
    """What goes on: the turn that somebody drives, and why it is not recorded as an episode."""

    turn: int | None = None
    task: str = ""
    stopped: bool = False
    faulted: bool = False

    @property
    def why_not(self) -> str | None:
        return _STOPPED if self.stopped else _FAULT if self.faulted else None


class EpisodeFinder:
    """Finds the episodes; give it each part and its events in order.

    With `joins`, an episode goes on through a Stop or a fault.
    """

    def __init__(self, *, joins: bool = False) -> None:
        self._joins = joins
        self._division = Division()
        self._state = _State()
        self._since_s = 0.0
        self._newest_s = -math.inf
        self._part_s = self._settled_s = -math.inf
        self._before: _State | None = None

    def begin_part(self, began_s: float) -> None:
        """Begin a part; its first events repeat what goes on, so they decide what continues."""
        self._settle()
        if not -_OVERLAP_S <= began_s - self._newest_s <= QUIET_S:
            self._change(_State(), self._newest_s)
            self._newest_s = began_s
        self._before, self._state = self._state, _State()
        self._part_s = began_s
        self._settled_s = self._newest_s = max(began_s, self._newest_s)

    def add(self, at_s: float, event: TapeEvent) -> None:
        """Add an event of the part."""
        if at_s > self._part_s:
            self._settle()
        if isinstance(event, Missed) and self._before is None:
            state = self._state
            self._change(_State(), at_s - event.missed_s)
            self._change(state, at_s)
        self._set(self._after(event), at_s)
        self._newest_s = max(self._newest_s, at_s)

    def finish(self) -> Division:
        """Return what was found."""
        self._settle()
        self._change(_State(), self._newest_s)
        return self._division

    def _after(self, event: TapeEvent) -> _State:
        state = self._state
        match event:
            case Turned():
                turn = None if event.operator is None else event.number
                same = turn == state.turn
                return state if same else replace(state, turn=turn, task="", faulted=False)
            case Tasked() if event.turn == state.turn:
                return replace(state, task=event.text)
            case Stopped():
                return replace(state, stopped=event.pressed)
            case Faulted():
                return replace(state, faulted=True)
            case Steered() if event.reason is None:
                return replace(state, faulted=False)
        return state

    def _set(self, state: _State, at_s: float) -> None:
        if self._before is None:
            self._change(state, at_s)
        else:
            self._state = state

    def _settle(self) -> None:
        """Compare the state that a part's first events repeat with the state before the part."""
        if self._before is not None:
            repeated, self._state, self._before = self._state, self._before, None
            # A fault is not repeated: it lasts until a set-point has no reason to hold the robot.
            lasts = self._state.faulted and repeated.turn == self._state.turn
            self._change(replace(repeated, faulted=lasts or repeated.faulted), self._settled_s)

    def _change(self, state: _State, at_s: float) -> None:
        """End the piece that the change of state ends, and begin the next."""
        before = self._state
        self._state = state
        same = before.turn == state.turn
        if same and (self._joins or before.why_not == state.why_not):
            return
        if before.turn is not None and at_s > self._since_s:
            why = None if self._joins else before.why_not
            if why is None:
                whole = Episode(before.turn, self._since_s, at_s, before.task)
                self._division.episodes += _pieces(whole)
            else:
                self._division.left_out.append(LeftOut(self._since_s, at_s, why))
        self._since_s = at_s


def _pieces(whole: Episode) -> Iterable[Episode]:
    while whole.end_s - whole.begin_s > LONGEST_S:
        until_s = whole.begin_s + LONGEST_S
        yield replace(whole, end_s=until_s)
        whole = replace(whole, begin_s=until_s)
    yield whole
