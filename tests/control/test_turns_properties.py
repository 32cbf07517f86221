"""The queue and the turns against random histories, with all rules on."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule
from tests.examples import examples

from wax.config.turns import TurnSettings
from wax.control.fairness import Person
from wax.control.turn_time import MAX_PAUSE_S
from wax.control.turns import (
    COMES_S,
    Called,
    PassedOver,
    PlaceLost,
    TurnEnded,
    TurnRenewed,
    Turns,
    TurnStarted,
    Why,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.control.turns import TurnEvent

VIEWERS = st.integers(1, 6)
EPSILON_S = 1e-6

PEOPLE = {
    1: Person("ann", "home"),
    2: Person("bob", "school"),
    3: Person("cid", "school"),
    4: Person("dan", "afar", is_invited=True),
    5: Person("eve", "afar", is_invited=True),
    6: Person("ann", "home"),  # a second page of the first
}


class TurnsMachine(RuleBasedStateMachine):
    """Random connects here and elsewhere, joins, leaves, losses, returns, answers, late ticks;
    acts of the host, who also changes their mind about who may queue.

    It keeps its own, naive record of who is there, and checks each event against it.
    """

    def __init__(self) -> None:
        super().__init__()
        self.now_s = 0.0
        self.policy = TurnSettings()
        self.turns = Turns(self.policy)
        self.number = 0
        self.running: int | None = None  # the operator according to the events alone
        self.begun_s = 0.0
        self.renewed_s = 0.0  # or begun
        self.stood_s = 0.0  # for how long the turn's clock stood still
        self.is_kept = False
        self.is_paused = False  # its clock stands still: it was told at the newest tick
        self.is_held = False
        self.late_s = 0.0
        self.people = dict(PEOPLE)
        self.known: set[int] = set()
        self.away_since_s: dict[int, float] = {}
        self.lost: set[int] = set()
        self.lost_since_s: dict[int, float] = {}
        self.acted_s: dict[int, float] = {}
        self.called: Called | None = None
        self.answered: int | None = None
        self.missed: dict[int, int] = {}
        self.passed_over: set[int] = set()
        self.driven: list[tuple[Person, float, float]] = []
        self.drives_by_s: dict[int, float] = {}  # the promise to each present waiting viewer

    @initialize(
        raw=st.fixed_dictionaries(
            {
                "turn_s": st.sampled_from([5.0, 12.5, 60.0]),
                "grace_s": st.sampled_from([0.0, 1.0, 3.0]),
                "join": st.sampled_from(["ask", "auto"]),
                "ready_s": st.sampled_from([0.0, 0.0, 10.0]),
                "idle_s": st.sampled_from([0.0, 0.0, 7.0]),
                "cooldown_s": st.sampled_from([0.0, 0.0, 100.0]),
                "max_share_per_person": st.sampled_from([1.0, 1.0, 0.4]),
                "max_share_per_address": st.sampled_from([1.0, 1.0, 0.5]),
                "invited_first": st.booleans(),
                "max_waiting_per_address": st.sampled_from([50, 2, 1]),
            }
        )
    )
    def build(self, raw: dict[str, object]) -> None:
        self.policy = TurnSettings.model_validate(raw)
        self.turns = Turns(self.policy)

    def act(self, method: Callable[..., tuple[TurnEvent, ...]], *arguments: object) -> None:
        order = list(self.turns.queue)
        events = method(*arguments, self.now_s)
        for event in events:
            self.follow(event, order)
        if method == self.tick:
            self.follow_pause()
        self.check_order(order, events)
        self.renew_promises()

    def follow(self, event: TurnEvent, order: list[int]) -> None:
        match event:
            case TurnStarted(number, operator, ends_s):
                assert self.running is None, "two operators"
                assert operator in self.known
                assert operator not in self.lost, "a turn was given to somebody lost"
                assert operator not in self.away_since_s, "a turn began for somebody elsewhere"
                assert not self.is_held, "a turn began while the queue was held"
                assert ends_s == self.now_s + self.policy.turn_s, "not a whole turn"
                assert number == self.number + 1, "the number did not rise by one"
                assert self.is_ready(operator), "a turn was given to somebody absent"
                self.check_turn(operator, order)
                promise_s = self.drives_by_s.pop(operator, self.now_s)
                assert self.now_s <= promise_s + EPSILON_S, "somebody waited longer than promised"
                self.number = number
                self.running, self.begun_s, self.renewed_s = operator, self.now_s, self.now_s
                self.begin_clock()
                self.begin_calls()
            case TurnRenewed(number, operator, ends_s):
                assert (number, operator) == (self.number, self.running)
                assert operator not in self.lost, "a lost operator's turn renewed"
                assert not self.is_held, "a turn renewed while the queue was held"
                assert not self.there(), "a turn renewed while somebody was waiting"
                assert self.now_s < ends_s <= self.now_s + self.policy.turn_s
                self.renewed_s = ends_s - self.policy.turn_s
                self.begin_clock()
                self.begin_calls()
            case TurnEnded():
                self.end(event)
            case Called(viewer, until_s):
                if self.running is None and not self.there():
                    self.passed_over.clear()  # nobody else is there
                assert not self.is_held
                may_come = {*self.away_since_s} - self.lost - self.passed_over
                is_to_come = self.running is not None and viewer in may_come
                assert viewer in self.there() or is_to_come
                assert until_s == self.now_s + self.policy.ready_s
                self.called, self.answered = event, None
            case PassedOver(viewer):
                self.expire(viewer, times=1)
            case PlaceLost(viewer, None):
                self.lose_place(viewer)
            case PlaceLost(viewer, why):
                assert self.turns.refusal(viewer) == why
                self.drop(viewer)

    def end(self, ended: TurnEnded) -> None:
        assert (ended.number, ended.operator) == (self.number, self.running)
        if ended.why is Why.EXPIRED:
            drove_s = self.now_s - self.renewed_s - self.stood_s
            assert drove_s >= self.policy.turn_s - EPSILON_S
        if ended.why is Why.IDLE:
            assert self.now_s >= self.acted_s.get(ended.operator, 0.0) + self.policy.idle_s
        if ended.why is Why.NOT_ALLOWED:
            assert not self.people[ended.operator].may_queue
        self.driven.append((self.people[ended.operator], self.begun_s, self.now_s))
        self.running, self.is_paused = None, False

    def lose_place(self, viewer: int) -> None:
        called = self.called if viewer in self.missed else None
        has_missed = called is not None and called.viewer == viewer and called.until_s <= self.now_s
        if viewer in self.lost:
            assert self.now_s >= self.lost_since_s[viewer] + self.policy.grace_s
        elif viewer in self.away_since_s and not has_missed:
            assert self.now_s >= self.away_since_s[viewer] + COMES_S - EPSILON_S
            self.drop(viewer)
        else:
            self.expire(viewer, times=2)
            self.passed_over.discard(viewer)  # who comes again begins anew

    def expire(self, viewer: int, *, times: int) -> None:
        assert self.called is not None
        assert self.called.viewer == viewer
        assert self.answered is None
        assert self.now_s >= self.called.until_s
        self.missed[viewer] = self.missed.get(viewer, 0) + 1
        assert self.missed[viewer] == times
        if times == 2:
            self.missed.pop(viewer)
        self.passed_over.add(viewer)
        self.called = None

    def begin_calls(self) -> None:
        self.called = self.answered = None
        self.passed_over.clear()

    def is_ready(self, viewer: int) -> bool:
        if not self.policy.ready_s or viewer == self.answered:
            return True
        # An act counts for the turn that follows it by no more than the check and a turn's end.
        most_s = 2 * self.policy.ready_s + MAX_PAUSE_S + self.late_s
        return self.now_s - self.acted_s[viewer] < most_s

    def there(self) -> list[int]:
        gone = self.lost | self.passed_over | {*self.away_since_s}
        return [] if self.is_held else [v for v in self.turns.queue if v not in gone]

    def may_be_overtaken(self, viewer: int) -> bool:
        """Whether cool-down or shares let others go before this one, as the manual has it."""
        person, rules = self.people[viewer], self.policy
        ended_s = [end_s for one, _, end_s in self.driven if one.key == person.key]
        if ended_s and self.now_s < max(ended_s) + rules.cooldown_s + EPSILON_S:
            return True
        hour = [(p, e - max(b, self.now_s - 3600)) for p, b, e in self.driven]
        hour = [(p, s) for p, s in hour if s > 0]
        all_s = sum(s for _, s in hour)
        own_s = sum(s for p, s in hour if p.key == person.key)
        near_s = sum(s for p, s in hour if p.address == person.address)
        shares = rules.max_share_per_person, rules.max_share_per_address
        return own_s > shares[0] * all_s - EPSILON_S or near_s > shares[1] * all_s - EPSILON_S

    def check_turn(self, operator: int, order: list[int]) -> None:
        """Nobody of the same class who came earlier, is there and yields to nobody is left out."""
        before = order[: order.index(operator)] if operator in order else order
        if self.answered == operator or (self.called and self.called.viewer == operator):
            return  # who was called goes, whoever came meanwhile
        for other in before:
            if other not in self.there():
                continue
            is_other_class = PEOPLE[operator].is_invited and not PEOPLE[other].is_invited
            if self.policy.invited_first and is_other_class:
                continue
            just_drove = bool(self.driven) and self.driven[-1][0].key == self.people[other].key
            assert self.may_be_overtaken(other) or just_drove, f"{other} was overtaken"

    def check_order(self, before: list[int], events: tuple[TurnEvent, ...]) -> None:
        """Those who waited before and still do have not changed their order."""
        started = {event.operator for event in events if isinstance(event, TurnStarted)}
        after = list(self.turns.queue)
        stayed = [v for v in before if v in after and v not in started]
        assert [v for v in after if v in stayed] == stayed

    def renew_promises(self) -> None:
        waiting = [v for v in self.turns.queue if v not in self.lost | {*self.away_since_s}]
        for viewer in list(self.drives_by_s):
            if viewer not in waiting or self.turns.wait_s(viewer, self.now_s) is None:
                del self.drives_by_s[viewer]
        for viewer in waiting:
            wait_s = self.turns.wait_s(viewer, self.now_s)
            if wait_s is None:
                continue
            # A promise is kept, not renewed: later estimates may only be shorter.
            self.drives_by_s.setdefault(viewer, self.now_s + wait_s)

    def postpone(self, by_s: float) -> None:
        """Delay every promise: a clock may stand still, somebody is called, a tick is late."""
        for viewer in self.drives_by_s:
            self.drives_by_s[viewer] += by_s

    def begin_clock(self) -> None:
        """Let the clock run: only a tick says what keeps an operator from driving."""
        self.is_paused, self.stood_s = False, 0.0

    def follow_pause(self) -> None:
        was_paused, self.is_paused = self.is_paused, self.is_kept and self.running is not None
        if self.is_paused and not was_paused:
            self.postpone(MAX_PAUSE_S - self.stood_s)

    def next_due_s(self) -> float:
        """When the turn, somebody's grace or a call ends; infinite if nothing is pending."""
        grace_ends_s = [self.lost_since_s[viewer] + self.policy.grace_s for viewer in self.lost]
        pending_s = [end_s for end_s in grace_ends_s if end_s > self.now_s]
        if self.turns.ends_s is not None:
            pending_s.append(self.turns.ends_s)
            if self.policy.ready_s and self.turns.ends_s - self.policy.ready_s > self.now_s:
                pending_s.append(self.turns.ends_s - self.policy.ready_s)
        if self.called is not None and self.answered is None:
            pending_s.append(self.called.until_s)
        return min(pending_s, default=math.inf)

    def pass_time(self, until_s: float) -> None:
        if self.is_paused:
            left_s = MAX_PAUSE_S - self.stood_s
            self.stood_s += min(left_s, until_s - self.now_s)
        if self.running is None:
            self.postpone(until_s - self.now_s)  # a call is waited for
        self.now_s = until_s

    def tick(self, now_s: float) -> tuple[TurnEvent, ...]:
        return self.turns.tick(now_s, is_kept=self.is_kept)

    # --- what can happen ---------------------------------------------------------------------

    @rule(viewer=VIEWERS, is_here=st.sampled_from([True, True, False]))
    def connect(self, viewer: int, is_here: bool) -> None:
        self.act(self.tick)
        if viewer not in self.known or viewer in self.lost:
            self.acted_s[viewer] = self.now_s
        is_back = viewer not in self.known or viewer in self.lost or viewer in self.away_since_s
        if is_back and PEOPLE[viewer].is_invited:
            self.drives_by_s.clear()
        self.known.add(viewer)
        if is_here:
            self.away_since_s.pop(viewer, None)
        else:
            self.away_since_s.setdefault(viewer, self.now_s)
            self.drives_by_s.pop(viewer, None)
        if is_here or viewer != self.running:
            self.lost.discard(viewer)
        elif viewer not in self.lost:
            self.lost.add(viewer)
            self.lost_since_s[viewer] = self.now_s
        person = self.people[viewer]
        self.act(lambda now_s: self.turns.connect(viewer, now_s, person, is_here=is_here))

    @rule(viewer=VIEWERS, may_queue=st.booleans(), address=st.sampled_from(["home", "school"]))
    def the_door_says_otherwise(self, viewer: int, may_queue: bool, address: str) -> None:
        self.act(self.tick)
        person = replace(self.people[viewer], may_queue=may_queue, address=address)
        self.people[viewer] = person
        if viewer in self.known:
            self.drives_by_s.clear()  # another's share, counted by address, may be another one now
            self.act(lambda now_s: self.turns.update_person(viewer, person, now_s))

    @rule(viewer=VIEWERS)
    def join(self, viewer: int) -> None:
        if self.turns.place(viewer) is None:
            self.acted_s[viewer] = self.now_s
            if PEOPLE[viewer].is_invited:
                self.drives_by_s.clear()  # they go first, which nobody could know
        self.act(self.turns.join, viewer)

    @rule(viewer=VIEWERS)
    def leave(self, viewer: int) -> None:
        self.drop(viewer)
        self.act(self.turns.leave, viewer)
        assert self.turns.place(viewer) is None

    def drop(self, viewer: int) -> None:
        self.drives_by_s.pop(viewer, None)
        self.missed.pop(viewer, None)
        self.passed_over.discard(viewer)
        if self.called is not None and self.called.viewer == viewer:
            self.called = self.answered = None

    @rule(viewer=VIEWERS)
    def answer(self, viewer: int) -> None:
        if viewer in self.known:
            self.acted_s[viewer] = self.now_s
            self.missed.pop(viewer, None)
            if viewer in self.passed_over:
                self.passed_over.discard(viewer)
                self.drives_by_s.clear()
            if self.called is not None and self.called.viewer == viewer:
                self.answered = viewer
        self.act(self.turns.answer, viewer)

    @rule(viewer=VIEWERS)
    def drives(self, viewer: int) -> None:
        if viewer == self.running:
            self.acted_s[viewer] = self.now_s
            self.missed.pop(viewer, None)
        self.turns.record_motion(viewer, self.now_s)

    @rule(viewer=VIEWERS)
    def lose(self, viewer: int) -> None:
        if viewer in self.known and viewer not in self.lost:
            self.lost.add(viewer)
            self.lost_since_s[viewer] = self.now_s
            self.drives_by_s.pop(viewer, None)
            if self.called is not None and self.called.viewer == viewer:
                self.called = self.answered = None
        self.act(self.turns.lost, viewer)

    @rule(viewer=VIEWERS)
    def come_back(self, viewer: int) -> None:
        if viewer in self.lost:
            self.lost.discard(viewer)
            self.acted_s[viewer] = max(self.acted_s.get(viewer, 0.0), self.now_s)
            if PEOPLE[viewer].is_invited:
                self.drives_by_s.clear()
        self.act(self.turns.returned, viewer)

    @rule(viewer=VIEWERS)
    def close(self, viewer: int) -> None:
        self.drop(viewer)
        self.known.discard(viewer)
        self.lost.discard(viewer)
        self.away_since_s.pop(viewer, None)
        self.act(self.turns.gone, viewer)
        assert self.turns.place(viewer) is None

    @rule()
    def host_ends_the_turn(self) -> None:
        self.act(self.turns.end)
        assert self.turns.ends_s is None or self.turns.ends_s == self.now_s + self.policy.turn_s

    @rule(is_held=st.booleans())
    def host_holds(self, is_held: bool) -> None:
        self.is_held = is_held
        if is_held:
            self.drives_by_s.clear()
            self.called = self.answered = None
        self.act(lambda now_s: self.turns.hold(is_held, now_s))

    @rule(is_kept=st.booleans())
    def something_keeps_them_from_driving(self, is_kept: bool) -> None:
        self.is_kept = is_kept
        self.act(self.tick)

    @rule(pass_s=st.floats(0.0, 200.0))
    def time_passes(self, pass_s: float) -> None:
        """Tick at every deadline, as the control loop nearly does."""
        until_s = self.now_s + pass_s
        while (due_s := self.next_due_s()) <= until_s:
            self.pass_time(due_s)
            self.act(self.tick)
            assert self.next_due_s() > due_s, "what was due is still to be done"
        self.pass_time(until_s)
        self.act(self.tick)

    @rule(pass_s=st.floats(0.0, 500.0))
    def time_passes_unseen(self, pass_s: float) -> None:
        """One late tick after a gap, which delays every promise by no more than the gap."""
        self.late_s = pass_s
        self.postpone(pass_s)
        self.pass_time(self.now_s + pass_s)
        self.act(self.tick)
        self.late_s = 0.0

    # --- what always holds -------------------------------------------------------------------

    @invariant()
    def agrees_with_its_events(self) -> None:
        assert self.turns.operator == self.running
        assert self.turns.number == self.number

    @invariant()
    def everybody_has_one_role(self) -> None:
        line = [v for v in (self.turns.operator, *self.turns.queue) if v is not None]
        assert len({self.people[v].key for v in line}) == len(line), "one person has two places"
        assert set(line) <= self.known
        assert all(self.people[v].may_queue for v in line), "somebody has a place who may not"
        at = [self.people[v].address for v in self.turns.queue]
        most = self.policy.max_waiting_per_address
        assert all(at.count(one) <= most for one in at), "too many of one address wait"
        assert {v for v in self.known if self.turns.is_lost(v)} == self.lost

    @invariant()
    def nobody_idles(self) -> None:
        """While somebody who is there waits, somebody drives, or is asked to."""
        if self.turns.operator is None and self.turns.call is None:
            assert not self.there()

    @invariant()
    def no_turn_is_too_long(self) -> None:
        if self.turns.ends_s is not None:
            rest_s = self.turns.ends_s - self.now_s
            assert 0 < rest_s <= self.policy.turn_s + MAX_PAUSE_S + EPSILON_S

    @invariant()
    def no_grace_is_too_long(self) -> None:
        for viewer in (*self.turns.queue, self.turns.operator):
            if viewer in self.lost:
                assert self.now_s < self.lost_since_s[viewer] + self.policy.grace_s


TestTurns = TurnsMachine.TestCase
TestTurns.settings = examples(150, stateful_step_count=60)
