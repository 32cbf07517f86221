"""The queue and the turns: who drives, until when, and who is next (thesis 3.2 and 4.3).

TURNS.md says what the rules are and draws them. Only this module decides who may have a place:
`refusal` is checked for everybody who connects, joins, comes back or has just driven, and again
when a person's data change, so that an invitation that ends takes place or turn with it.

Viewers are numbers that are never reused. ``now_s`` never falls from call to call. Every call
first does what is due, in the order in which it fell due, so a late `tick` has one effect only: a
turn starts at the time of the call, not when it could have started.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum
from typing import TYPE_CHECKING, Final

from wax.control.fairness import Fairness, Person
from wax.control.ready_check import ReadyCheck
from wax.control.turn_time import TurnTime
from wax.sentence import Sentence

if TYPE_CHECKING:
    from wax.config.turns import TurnSettings
    from wax.control.ready_check import Call

COMES_S: Final = 20.0
"""A page that waits elsewhere polls every five seconds, and takes a few more to connect."""

_NOT_INVITED: Final = Sentence("queue.not_invited")
_OTHER_TAB: Final = Sentence("queue.other_tab")


class Why(Enum):
    """Why a turn ended."""

    EXPIRED = "expired"
    LEFT = "left"
    GONE = "gone"
    IDLE = "idle"
    ENDED = "ended by the host"
    NOT_ALLOWED = "not allowed any more"


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
class Called:
    """The next in the queue has until `until_s` to confirm that they are there."""

    viewer: int
    until_s: float


@dataclass(frozen=True, slots=True)
class PassedOver:
    """A called viewer did not answer; they keep their place this once."""

    viewer: int


@dataclass(frozen=True, slots=True)
class PlaceLost:
    """A waiting viewer has lost their place.

    They stayed lost for `grace_s`, missed two calls, did not come for their turn, or may not have a
    place any more; in the last case `why` says so.
    """

    viewer: int
    why: Sentence | None = None


TurnEvent = TurnStarted | TurnRenewed | TurnEnded | Called | PassedOver | PlaceLost


@dataclass(frozen=True, slots=True)
class _Turn:
    operator: int
    begun_s: float
    time: TurnTime
    acted_s: float  # when the operator last commanded something


class Turns:
    """The state machine of queue and turns.

    Every method returns what happened, in order. Calls for unconnected viewers change nothing.
    """

    def __init__(self, settings: TurnSettings) -> None:
        self._settings = settings
        self._people: dict[int, Person] = {}
        self._lost_since_s: dict[int, float] = {}  # within grace; in the order of loss
        self._lapsed: set[int] = set()  # lost for longer than the grace time
        self._away: set[int] = set()  # viewers who wait elsewhere
        self._missing: tuple[int, float] | None = None  # who should connect, and since when
        self._queue: list[int] = []
        self._turn: _Turn | None = None
        self._number = 0
        self._fairness = Fairness(settings)
        self._ready = ReadyCheck(settings.ready_s)
        self._just_drove: int | None = None
        self._wanted_s = math.inf  # since when somebody else could drive
        self._is_held = False

    @property
    def operator(self) -> int | None:
        """Whose turn it is, lost or not."""
        return None if self._turn is None else self._turn.operator

    @property
    def number(self) -> int:
        """The newest turn's number, which only rises; 0 before the first."""
        return self._number

    @property
    def ends_s(self) -> float | None:
        """When this turn ends or renews, at the latest; None while nobody drives."""
        return None if self._turn is None else self._turn.time.ends_s

    @property
    def queue(self) -> tuple[int, ...]:
        """The waiting viewers, the next first, without the operator."""
        return tuple(self._queue)

    @property
    def call(self) -> Call | None:
        """The open call; None once it is answered."""
        call = self._ready.call
        return None if call is None or call.is_answered else call

    def paused_left_s(self, now_s: float) -> float | None:
        """Return what is left of a turn whose clock is paused; None while it runs."""
        turn = self._turn
        if turn is None or not turn.time.is_paused_at(now_s):
            return None
        return turn.time.left_at(now_s)

    def is_lost(self, viewer: int) -> bool:
        """Whether the viewer's connection is lost."""
        return viewer in self._lost_since_s or viewer in self._lapsed

    def place(self, viewer: int) -> int | None:
        """Return 0 for the operator, 1… for waiting viewers, None for everybody else."""
        if viewer == self.operator:
            return 0
        return self._queue.index(viewer) + 1 if viewer in self._queue else None

    def refusal(self, viewer: int) -> Sentence | None:
        """Return why a viewer gets no place; None if they have one or would get one."""
        person = self._people.get(viewer)
        if person is None or self.place(viewer) is not None:
            return None
        if not person.may_queue:
            return _NOT_INVITED
        if any(self._people[one].key == person.key for one in self._operator_and_queue()):
            return _OTHER_TAB
        most = self._settings.max_waiting_per_address
        if sum(self._people[one].address == person.address for one in self._queue) >= most:
            return Sentence("queue.neighbours", {"n": most})
        return None

    def wait_s(self, viewer: int, now_s: float) -> float | None:
        """Estimate the longest time the viewer may wait, in seconds: 0 for the operator.

        It is the rest of this turn plus a whole turn for everybody who may go first. The wait is
        shorter if one of them leaves or is away, longer if a clock pauses or a call is open. It is
        None for observers and lost viewers, and while it cannot be known: the host holds the queue,
        others go first after this viewer's last turn, or invited people keep taking turns.
        """
        _, wait_s = self.places(now_s).get(viewer, (None, None))
        return wait_s

    def places(self, now_s: float) -> dict[int, tuple[int, float | None]]:
        """Return `place` and `wait_s` of each who has a place: one walk along the queue for all."""
        turn, turn_s = self._turn, self._settings.turn_s
        rest_s = 0.0 if turn is None else max(0.0, turn.time.ends_s - now_s)
        is_first = self._settings.invited_first
        invited = {
            one for one in self._operator_and_queue() if is_first and self._people[one].is_invited
        }
        found: dict[int, tuple[int, float | None]] = {}
        if turn is not None:
            found[turn.operator] = 0, None if self._has_no_wait(turn.operator) else 0.0
        before: set[int] = set()
        for place, viewer in enumerate(self._queue, 1):
            wait_s = None
            if not self._has_no_wait(viewer):
                first = self._may_go_first(viewer, before, invited, now_s)
                wait_s = None if first is None else rest_s + first * turn_s
            found[viewer] = place, wait_s
            before.add(viewer)
        return found

    def _has_no_wait(self, viewer: int) -> bool:
        return self._is_held or self.is_lost(viewer)

    def connect(
        self, viewer: int, now_s: float, person: Person | None = None, *, is_here: bool = True
    ) -> tuple[TurnEvent, ...]:
        """Register that a viewer connects or reconnects; with `is_here` false they wait elsewhere.

        Without a `person` the viewer counts as a person of their own. An operator who waits
        elsewhere counts as lost.
        """
        events = self._catch_up(now_s)
        if viewer not in self._people:
            self._people[viewer] = person or Person(str(viewer))
            self._set_presence(viewer, is_here)
            self._welcome(viewer, now_s)
        else:
            events += self._update_person(viewer, person, now_s)
            self._set_presence(viewer, is_here)
            if is_here or viewer != self.operator:
                self._return(viewer, now_s)
            elif not self.is_lost(viewer):
                self._lost_since_s[viewer] = now_s
        return (*events, *self._catch_up(now_s))

    def update_person(self, viewer: int, person: Person, now_s: float) -> tuple[TurnEvent, ...]:
        """Update the person behind a viewer, who loses their place if they may no longer queue."""
        if self._people.get(viewer, person) == person:
            return ()
        events = self._catch_up(now_s)
        events += self._update_person(viewer, person, now_s)
        return (*events, *self._catch_up(now_s))

    def join(self, viewer: int, now_s: float) -> tuple[TurnEvent, ...]:
        """Put a viewer at the end of the queue.

        This has no effect if they have a place, are lost, or `refusal` gives a reason.
        """
        events = self._catch_up(now_s)
        if viewer in self._people and not self.is_lost(viewer):
            self._enqueue(viewer, now_s)
        return (*events, *self._catch_up(now_s))

    def leave(self, viewer: int, now_s: float) -> tuple[TurnEvent, ...]:
        """Take the viewer's turn or place; they observe."""
        events = self._catch_up(now_s)
        events += self._give_up(viewer, Why.LEFT, now_s)
        return (*events, *self._catch_up(now_s))

    def answer(self, viewer: int, now_s: float) -> tuple[TurnEvent, ...]:
        """Register that a viewer is present, which answers their call."""
        events = self._catch_up(now_s)
        if viewer in self._people:
            self._ready.record_activity(viewer, now_s)
        return (*events, *self._catch_up(now_s))

    def record_motion(self, viewer: int, now_s: float) -> None:
        """Register that the operator commands motion; this makes nothing fall due."""
        if self._turn is not None and viewer == self._turn.operator:
            self._turn = replace(self._turn, acted_s=now_s)
            self._ready.record_activity(viewer, now_s)

    def lost(self, viewer: int, now_s: float) -> tuple[TurnEvent, ...]:
        """Start the grace time of a viewer whose connection is lost."""
        events = self._catch_up(now_s)
        if viewer in self._people and not self.is_lost(viewer):
            self._lost_since_s[viewer] = now_s
            self._ready.cancel(viewer)
        return (*events, *self._catch_up(now_s))

    def returned(self, viewer: int, now_s: float) -> tuple[TurnEvent, ...]:
        """Register that a lost viewer is back."""
        events = self._catch_up(now_s)
        self._return(viewer, now_s)
        return (*events, *self._catch_up(now_s))

    def gone(self, viewer: int, now_s: float) -> tuple[TurnEvent, ...]:
        """Forget a viewer who has left for good."""
        events = self._catch_up(now_s)
        events += self._give_up(viewer, Why.GONE, now_s)
        self._people.pop(viewer, None)
        self._lost_since_s.pop(viewer, None)
        self._lapsed.discard(viewer)
        self._away.discard(viewer)
        return (*events, *self._catch_up(now_s))

    def end(self, now_s: float) -> tuple[TurnEvent, ...]:
        """End the turn, as the host asks; its operator observes."""
        events = self._catch_up(now_s)
        if self._turn is not None:
            events += self._give_up(self._turn.operator, Why.ENDED, now_s)
        return (*events, *self._catch_up(now_s))

    def hold(self, is_held: bool, now_s: float) -> tuple[TurnEvent, ...]:
        """Pause or resume the queue, as the host asks."""
        events = self._catch_up(now_s)
        self._is_held = is_held
        self._missing = None
        if is_held and self._ready.call is not None:
            self._ready.cancel(self._ready.call.viewer)
        return (*events, *self._catch_up(now_s))

    def tick(self, now_s: float, *, is_kept: bool = False) -> tuple[TurnEvent, ...]:
        """Do what is due; `is_kept` while something keeps the operator from driving."""
        events = self._catch_up(now_s)
        turn = self._turn
        if turn is not None and turn.time.is_paused != is_kept:
            # An operator who could not drive is not idle.
            time = turn.time.paused(is_kept, now_s)
            self._turn = replace(turn, time=time, acted_s=max(turn.acted_s, now_s))
            events += self._catch_up(now_s)
        return tuple(events)

    # --- what falls due ----------------------------------------------------------------------

    def _catch_up(self, now_s: float) -> list[TurnEvent]:
        events: list[TurnEvent] = []
        while True:
            grace_s, call_s = self._first_grace_s(), self._ready.expires_s
            ends_s, missing_s = self._turn_ends_s(), self._missing_expires_s()
            # At the same instant grace goes first: an expired viewer does not queue again.
            if grace_s <= min(now_s, ends_s, call_s):
                events += self._expire_grace(now_s)
            elif call_s <= min(now_s, ends_s):
                events += self._miss_call(now_s)
            elif ends_s <= now_s:
                events += self._turn_over(now_s)
            elif missing_s <= now_s:
                events += self._give_up_missing(now_s)
            elif self._queue and (next_events := self._start_next(now_s)):
                events += next_events
            else:
                break
        for event in list(events):
            if isinstance(event, TurnEnded) and event.operator in self._queue:
                events += self._recheck_place(event.operator)
        is_wanted = self._turn is not None and bool(self._ready_to_start())
        self._wanted_s = min(self._wanted_s, now_s) if is_wanted else math.inf
        return events

    def _turn_ends_s(self) -> float:
        """Return when the turn ends: its time is up, or its operator is idle."""
        return math.inf if self._turn is None else min(self._turn.time.ends_s, self._idles_s())

    def _idles_s(self) -> float:
        """Return when the operator counts as idle; infinite while nobody else wants to drive."""
        turn, idle_s = self._turn, self._settings.idle_s
        if turn is None or not idle_s or turn.time.is_paused or self.is_lost(turn.operator):
            return math.inf
        return max(turn.acted_s, self._wanted_s) + idle_s

    def _expire_grace(self, now_s: float) -> list[TurnEvent]:
        viewer = next(iter(self._lost_since_s))
        del self._lost_since_s[viewer]
        self._lapsed.add(viewer)
        waited = viewer in self._queue
        events = self._give_up(viewer, Why.GONE, now_s)
        return [PlaceLost(viewer)] if waited else events

    def _miss_call(self, now_s: float) -> list[TurnEvent]:
        viewer, is_second = self._ready.expire()
        if not is_second:
            return [PassedOver(viewer)]
        self._give_up(viewer, Why.GONE, now_s)
        return [PlaceLost(viewer)]

    def _turn_over(self, now_s: float) -> list[TurnEvent]:
        turn = self._turn
        assert turn is not None
        if self._idles_s() < turn.time.ends_s:
            return self._give_up(turn.operator, Why.IDLE, now_s)
        if self._may_renew(turn):
            return [*self._record_missing(now_s), self._renew(turn, now_s)]
        self._end_turn(turn, now_s)
        self._queue.append(turn.operator)  # `_catch_up` removes them again if there is no room
        return [TurnEnded(self._number, turn.operator, Why.EXPIRED)]

    def _may_renew(self, turn: _Turn) -> bool:
        return not (self._is_held or self.is_lost(turn.operator) or self._ready_to_start())

    def _renew(self, turn: _Turn, now_s: float) -> TurnRenewed:
        turn_s, ends_s = self._settings.turn_s, turn.time.ends_s
        ends_s += (math.floor((now_s - ends_s) / turn_s) + 1) * turn_s
        if ends_s <= now_s:  # rounding may give an end that is already past
            ends_s += turn_s
        time = TurnTime(now_s, min(ends_s - now_s, turn_s))
        self._turn = replace(turn, time=time)
        self._ready.begin_turn()
        return TurnRenewed(self._number, turn.operator, time.ends_s)

    def _give_up(self, viewer: int, why: Why, now_s: float) -> list[TurnEvent]:
        self._ready.forget(viewer)
        self._clear_missing(viewer)
        if self._turn is not None and viewer == self._turn.operator:
            self._end_turn(self._turn, now_s)
            return [TurnEnded(self._number, viewer, why)]
        if viewer in self._queue:
            self._queue.remove(viewer)
        return []

    def _end_turn(self, turn: _Turn, now_s: float) -> None:
        self._fairness.record(self._people[turn.operator], turn.begun_s, now_s)
        self._just_drove = turn.operator
        self._turn = None

    # --- who is next -------------------------------------------------------------------------

    def _start_next(self, now_s: float) -> list[TurnEvent]:
        """Begin the next turn or call its operator; do nothing if it is too early for either."""
        if not self._ready.is_due(self.ends_s, now_s):
            return []
        viewer = self._next(now_s)
        if viewer is None and self._turn is None and self._here(self._waiting()):
            self._ready.begin_turn()  # nobody else is there: call those passed over again
            viewer = self._next(now_s)
        if viewer is None:
            return self._record_missing(now_s) if self._turn is None else []
        if not self._ready.is_ready(viewer, now_s):
            call = self._ready.start_call(viewer, now_s)
            return [] if call is None else [Called(viewer, call.until_s)]
        if self._turn is None:
            return [*self._record_missing(now_s), self._start(viewer, now_s)]
        self._ready.confirm(viewer)
        return []

    def _start(self, viewer: int, now_s: float) -> TurnStarted:
        self._queue.remove(viewer)
        self._number += 1
        self._turn = _Turn(viewer, now_s, TurnTime(now_s, self._settings.turn_s), acted_s=now_s)
        self._just_drove = None
        self._ready.begin_turn()
        return TurnStarted(self._number, viewer, self._turn.time.ends_s)

    def _next(self, now_s: float) -> int | None:
        """Return who drives next; during a turn, it may be a viewer who has yet to connect."""
        there = self._ready_to_start() if self._turn is None else self._willing()
        if self._ready.call is not None and self._ready.call.viewer in there:
            return self._ready.call.viewer
        return self._first(there, now_s)

    def _first(self, viewers: list[int], now_s: float) -> int | None:
        return min(viewers, key=lambda one: self._rank(one, now_s), default=None)

    def _ready_to_start(self) -> list[int]:
        """Return the viewers whose turn may begin now; none while the queue is held."""
        return self._here(self._willing())

    def _here(self, viewers: list[int]) -> list[int]:
        return [one for one in viewers if one not in self._away]

    def _willing(self) -> list[int]:
        """Return the waiting viewers, here or elsewhere, who were not passed over."""
        return [one for one in self._waiting() if not self._ready.is_passed_over(one)]

    def _waiting(self) -> list[int]:
        return [] if self._is_held else [one for one in self._queue if not self.is_lost(one)]

    def _rank(self, viewer: int, now_s: float) -> tuple[bool, tuple[bool, bool, bool]]:
        rank = self._fairness.rank(self._people[viewer], now_s)
        return viewer == self._just_drove, rank

    def _may_go_first(
        self, viewer: int, before: set[int], invited: set[int], now_s: float
    ) -> int | None:
        """Return how many turns may come before a waiting viewer's; None if unbounded.

        `before` wait in front of them, `invited` are those in the queue who go first.
        """
        me = self._people[viewer]
        if self._fairness.may_be_overtaken(me, now_s):
            return None
        if viewer in invited:
            before = before & invited
        # A called viewer goes next, whoever has joined meanwhile.
        call = self._ready.call
        called = None if call is None or call.viewer not in self._queue else call.viewer
        count = len(before) + (called not in (None, viewer) and called not in before)
        if not invited or viewer in invited:
            return count
        if len(invited) > 1:
            return None
        strangers = count - sum(one in before or one == called for one in invited)
        # A single invited person drives before each stranger, but not twice in a row.
        times = strangers if self.operator in invited else strangers + 1
        return strangers + times * len(invited)

    def _operator_and_queue(self) -> list[int]:
        return [*self._queue] if self._turn is None else [self._turn.operator, *self._queue]

    def _first_grace_s(self) -> float:
        """Return when the first grace time ends: that of the first loss, since all are equal."""
        for lost_since_s in self._lost_since_s.values():
            return lost_since_s + self._settings.grace_s
        return math.inf

    # --- who waits elsewhere -----------------------------------------------------------------

    def _record_missing(self, now_s: float) -> list[TurnEvent]:
        """Record the first viewer who misses a turn that begins now, or could, by being elsewhere.

        A viewer recorded `COMES_S` ago has had the time to connect, and loses the place.
        """
        events = self._give_up_missing(now_s) if self._missing_until_s() <= now_s else []
        first = self._first(self._willing(), now_s)
        if first in self._away and self._missing_until_s() == math.inf:
            self._missing = first, now_s
        return events

    def _missing_until_s(self) -> float:
        """Return when the missing viewer loses the place; infinite if nobody is missing."""
        if self._missing is None:
            return math.inf
        return self._missing[1] + COMES_S

    def _missing_expires_s(self) -> float:
        """Return the same while nobody drives; during a turn, its end or renewal settles it."""
        return self._missing_until_s() if self._turn is None else math.inf

    def _give_up_missing(self, now_s: float) -> list[TurnEvent]:
        assert self._missing is not None
        viewer, _ = self._missing
        self._give_up(viewer, Why.GONE, now_s)
        return [PlaceLost(viewer)]

    def _set_presence(self, viewer: int, is_here: bool) -> None:
        if not is_here:
            self._away.add(viewer)
            return
        self._away.discard(viewer)
        self._clear_missing(viewer)

    def _clear_missing(self, viewer: int) -> None:
        if self._missing is not None and self._missing[0] == viewer:
            self._missing = None

    # --- who gets a place --------------------------------------------------------------------

    def _update_person(self, viewer: int, person: Person | None, now_s: float) -> list[TurnEvent]:
        """Update the person behind a viewer; take their place if it is no longer allowed."""
        if viewer not in self._people or person in (None, self._people[viewer]):
            return []
        self._people[viewer] = person
        if viewer == self.operator:
            return [] if person.may_queue else self._give_up(viewer, Why.NOT_ALLOWED, now_s)
        if viewer not in self._queue:
            return []
        return self._recheck_place(viewer)

    def _recheck_place(self, viewer: int) -> list[TurnEvent]:
        """Remove a queued viewer whom `refusal` would now refuse a place."""
        place = self._queue.index(viewer)
        del self._queue[place]
        why = self.refusal(viewer)
        if why is None:
            self._queue.insert(place, viewer)
            return []
        self._ready.forget(viewer)
        self._clear_missing(viewer)
        return [PlaceLost(viewer, why)]

    def _return(self, viewer: int, now_s: float) -> None:
        self._lost_since_s.pop(viewer, None)
        if viewer in self._lapsed:
            self._lapsed.remove(viewer)
            self._welcome(viewer, now_s)

    def _welcome(self, viewer: int, now_s: float) -> None:
        if self._settings.join == "auto":
            self._enqueue(viewer, now_s)

    def _enqueue(self, viewer: int, now_s: float) -> None:
        if self.place(viewer) is None and self.refusal(viewer) is None:
            self._queue.append(viewer)
            self._ready.record_activity(viewer, now_s)
