"""The queue and the turns: who drives, until when, and who is next (thesis 3.2 and 4.3).

* A turn lasts `turn_s`. Then the next in the queue drives and the operator goes to its end.
* While nobody connected is waiting, the turn renews: same number, its end one `turn_s` later.
  A viewer who joins meanwhile waits for the rest of the current turn, never for another renewal.
* Leaving hands over at once.
* A lost connection keeps turn or place for `grace_s`; the turn's clock runs on. After that the
  turn or place is given up, and coming back is like connecting for the first time.
* A lost viewer never gets a turn: they are passed over, and keep their place in front until the
  grace time is over. An operator who is lost when the turn ends goes to the end of the queue. If
  everybody waiting is lost, nobody drives.
* With ``join = "auto"`` everybody queues at connect; those who leave observe until they join.

Viewers are numbers that are never reused. ``now_s`` never falls from call to call. Every call
first does what is due, in the order in which it fell due, so a late `tick` changes only this: a
turn starts when it is given, not when it could have been.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from wax.config.settings import TurnSettings


class Why(Enum):
    """Why a turn ended."""

    EXPIRED = "expired"
    LEFT = "left"
    GONE = "gone"


@dataclass(frozen=True, slots=True)
class TurnStarted:
    """`operator` drives from now until `ends_s`; `number` is higher than any before."""

    number: int
    operator: int
    ends_s: float


@dataclass(frozen=True, slots=True)
class TurnRenewed:
    """The same turn continues until the new `ends_s`."""

    number: int
    operator: int
    ends_s: float


@dataclass(frozen=True, slots=True)
class TurnEnded:
    """`operator` no longer drives."""

    number: int
    operator: int
    why: Why


@dataclass(frozen=True, slots=True)
class PlaceLost:
    """A waiting viewer stayed lost for `grace_s` and lost their place."""

    viewer: int


TurnEvent = TurnStarted | TurnRenewed | TurnEnded | PlaceLost


@dataclass(frozen=True, slots=True)
class _Turn:
    operator: int
    ends_s: float


class Turns:
    """The state machine of queue and turns.

    Every method returns what happened, in order. Calls for unconnected viewers change nothing.
    """

    def __init__(self, settings: TurnSettings) -> None:
        self._settings = settings
        self._known: set[int] = set()
        self._lost_since_s: dict[int, float] = {}  # within grace; in the order of loss
        self._lapsed: set[int] = set()  # lost for longer than that
        self._queue: list[int] = []
        self._turn: _Turn | None = None
        self._number = 0

    @property
    def operator(self) -> int | None:
        """Whose turn it is, lost or not."""
        return None if self._turn is None else self._turn.operator

    @property
    def number(self) -> int:
        """The newest turn's number; 0 before the first. It only rises."""
        return self._number

    @property
    def ends_s(self) -> float | None:
        """When this turn ends or renews; None while nobody drives."""
        return None if self._turn is None else self._turn.ends_s

    @property
    def queue(self) -> tuple[int, ...]:
        """The waiting viewers, the next first, without the operator."""
        return tuple(self._queue)

    def is_lost(self, viewer: int) -> bool:
        """Whether the viewer's connection is lost."""
        return viewer in self._lost_since_s or viewer in self._lapsed

    def place(self, viewer: int) -> int | None:
        """Return 0 for the operator, 1… for waiting viewers, None for everybody else."""
        if viewer == self.operator:
            return 0
        return self._queue.index(viewer) + 1 if viewer in self._queue else None

    def wait_s(self, viewer: int, now_s: float) -> float | None:
        """Return the longest time the viewer may wait, in seconds: 0 for the operator.

        It is the rest of this turn plus a whole turn for everybody in front, less if one of them
        leaves or is away. None for observers and lost viewers.
        """
        place = self.place(viewer)
        if place is None or self._turn is None or self.is_lost(viewer):
            return None
        if place == 0:
            return 0.0
        return max(0.0, self._turn.ends_s - now_s) + (place - 1) * self._settings.turn_s

    def connect(self, viewer: int, now_s: float) -> tuple[TurnEvent, ...]:
        """Register a viewer, once."""
        events = self._catch_up(now_s)
        if viewer not in self._known:
            self._known.add(viewer)
            self._welcome(viewer)
        return (*events, *self._catch_up(now_s))

    def join(self, viewer: int, now_s: float) -> tuple[TurnEvent, ...]:
        """Put a viewer at the end of the queue; no effect if they have a place or are lost."""
        events = self._catch_up(now_s)
        if viewer in self._known and not self.is_lost(viewer) and self.place(viewer) is None:
            self._queue.append(viewer)
        return (*events, *self._catch_up(now_s))

    def leave(self, viewer: int, now_s: float) -> tuple[TurnEvent, ...]:
        """Give up the viewer's turn or place; they observe."""
        events = self._catch_up(now_s)
        events += self._give_up(viewer, Why.LEFT)
        return (*events, *self._catch_up(now_s))

    def lost(self, viewer: int, now_s: float) -> tuple[TurnEvent, ...]:
        """Start the grace time of a viewer whose connection is lost."""
        events = self._catch_up(now_s)
        if viewer in self._known and not self.is_lost(viewer):
            self._lost_since_s[viewer] = now_s
        return (*events, *self._catch_up(now_s))

    def returned(self, viewer: int, now_s: float) -> tuple[TurnEvent, ...]:
        """Register that a lost viewer is back."""
        events = self._catch_up(now_s)
        self._lost_since_s.pop(viewer, None)
        if viewer in self._lapsed:
            self._lapsed.remove(viewer)
            self._welcome(viewer)
        return (*events, *self._catch_up(now_s))

    def gone(self, viewer: int, now_s: float) -> tuple[TurnEvent, ...]:
        """Forget a viewer who has left for good."""
        events = self._catch_up(now_s)
        events += self._give_up(viewer, Why.GONE)
        self._known.discard(viewer)
        self._lost_since_s.pop(viewer, None)
        self._lapsed.discard(viewer)
        return (*events, *self._catch_up(now_s))

    def tick(self, now_s: float) -> tuple[TurnEvent, ...]:
        """Do what is due."""
        return tuple(self._catch_up(now_s))

    def _catch_up(self, now_s: float) -> list[TurnEvent]:
        events: list[TurnEvent] = []
        while True:
            turn, grace_s = self._turn, self._first_grace_s()
            # At the same instant grace goes first: a viewer given up does not queue again.
            if grace_s <= now_s and (turn is None or grace_s <= turn.ends_s):
                events += self._lapse()
            elif turn is not None and turn.ends_s <= now_s:
                events += self._turn_over(turn, now_s)
            else:
                break
        if self._turn is None:
            events += self._start_next(now_s)
        return events

    def _lapse(self) -> list[TurnEvent]:
        viewer = next(iter(self._lost_since_s))
        del self._lost_since_s[viewer]
        self._lapsed.add(viewer)
        waited = viewer in self._queue
        events = self._give_up(viewer, Why.GONE)
        return [PlaceLost(viewer)] if waited else events

    def _turn_over(self, turn: _Turn, now_s: float) -> list[TurnEvent]:
        if self._next_present() is None and not self.is_lost(turn.operator):
            turn_s = self._settings.turn_s
            turns = math.floor((now_s - turn.ends_s) / turn_s) + 1
            ends_s = turn.ends_s + turns * turn_s
            if ends_s <= now_s:  # rounding may give the instant that is over now
                ends_s += turn_s
            self._turn = _Turn(turn.operator, min(ends_s, now_s + turn_s))
            return [TurnRenewed(self._number, turn.operator, self._turn.ends_s)]
        self._turn = None
        self._queue.append(turn.operator)
        return [TurnEnded(self._number, turn.operator, Why.EXPIRED)]

    def _give_up(self, viewer: int, why: Why) -> list[TurnEvent]:
        if viewer == self.operator:
            self._turn = None
            return [TurnEnded(self._number, viewer, why)]
        if viewer in self._queue:
            self._queue.remove(viewer)
        return []

    def _start_next(self, now_s: float) -> list[TurnEvent]:
        viewer = self._next_present()
        if viewer is None:
            return []
        self._queue.remove(viewer)
        self._number += 1
        self._turn = _Turn(viewer, now_s + self._settings.turn_s)
        return [TurnStarted(self._number, viewer, self._turn.ends_s)]

    def _next_present(self) -> int | None:
        return next((viewer for viewer in self._queue if not self.is_lost(viewer)), None)

    def _first_grace_s(self) -> float:
        """Return when the first grace time is over; all are equal, so the first loss is first."""
        for lost_since_s in self._lost_since_s.values():
            return lost_since_s + self._settings.grace_s
        return math.inf

    def _welcome(self, viewer: int) -> None:
        if self._settings.join == "auto":
            self._queue.append(viewer)
