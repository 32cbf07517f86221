"""The queue and the turns against random histories."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule
from tests.examples import examples

from wax.config.settings import TurnSettings
from wax.control.turns import PlaceLost, TurnEnded, TurnRenewed, Turns, TurnStarted, Why

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.control.turns import TurnEvent

VIEWERS = st.integers(1, 6)
EPSILON_S = 1e-6


class TurnsMachine(RuleBasedStateMachine):
    """Random connects, joins, leaves, losses, returns, ends, timely and late ticks.

    It keeps its own, naive record of who is there, and checks each event against it.
    """

    def __init__(self) -> None:
        super().__init__()
        self.now_s = 0.0
        self.turn_s = self.grace_s = 0.0
        self.turns = Turns(TurnSettings())
        self.number = 0
        self.running: int | None = None  # the operator according to the events alone
        self.started_s = 0.0
        self.known: set[int] = set()
        self.lost: set[int] = set()
        self.lost_since_s: dict[int, float] = {}
        self.drives_by_s: dict[int, float] = {}  # the promise to each present waiting viewer

    @initialize(
        turn_s=st.sampled_from([1.0, 2.5, 60.0]),
        grace_s=st.sampled_from([0.0, 1.0, 3.0]),
        join=st.sampled_from(["ask", "auto"]),
    )
    def build(self, turn_s: float, grace_s: float, join: str) -> None:
        self.turn_s, self.grace_s = turn_s, grace_s
        raw = {"turn_s": turn_s, "grace_s": grace_s, "join": join}
        self.turns = Turns(TurnSettings.model_validate(raw))

    def act(self, method: Callable[..., tuple[TurnEvent, ...]], *viewer: int) -> None:
        order = [v for v in self.turns.queue if not self.turns.is_lost(v)]
        events = method(*viewer, self.now_s)
        for event in events:
            self.follow(event)
        self.check_order(order, events)
        self.renew_promises()

    def follow(self, event: TurnEvent) -> None:
        match event:
            case TurnStarted(number, operator, ends_s):
                assert self.running is None, "two operators"
                assert operator in self.known
                assert operator not in self.lost, "a turn was given to somebody lost"
                assert ends_s == self.now_s + self.turn_s, "not a whole turn"
                assert number == self.number + 1, "the number did not rise by one"
                self.number = number
                self.running, self.started_s = operator, self.now_s
                promise_s = self.drives_by_s.pop(operator, self.now_s)
                assert self.now_s <= promise_s + EPSILON_S, "somebody waited longer than promised"
            case TurnRenewed(number, operator, ends_s):
                assert (number, operator) == (self.number, self.running)
                assert operator not in self.lost, "a lost operator's turn renewed"
                assert not self.drives_by_s, "a turn renewed while somebody was waiting"
                assert self.now_s < ends_s <= self.now_s + self.turn_s
                self.started_s = ends_s - self.turn_s
            case TurnEnded(number, operator, why):
                assert (number, operator) == (self.number, self.running)
                if why is Why.EXPIRED:
                    assert self.now_s >= self.started_s + self.turn_s
                self.running = None
            case PlaceLost(viewer):
                assert viewer in self.lost
                assert self.now_s >= self.lost_since_s[viewer] + self.grace_s

    def check_order(self, before: list[int], events: tuple[TurnEvent, ...]) -> None:
        """Those who waited before and still do have not changed their order."""
        started = {event.operator for event in events if isinstance(event, TurnStarted)}
        after = list(self.turns.queue)
        stayed = [v for v in before if v in after and v not in started]
        assert [v for v in after if v in stayed] == stayed

    def renew_promises(self) -> None:
        waiting = [v for v in self.turns.queue if v not in self.lost]
        for viewer in list(self.drives_by_s):
            if viewer not in waiting:
                del self.drives_by_s[viewer]
        for viewer in waiting:
            wait_s = self.turns.wait_s(viewer, self.now_s)
            assert wait_s is not None
            place = self.turns.place(viewer)
            assert place is not None
            assert wait_s <= place * self.turn_s + EPSILON_S
            # A promise is kept, not renewed: later estimates may only be shorter.
            self.drives_by_s.setdefault(viewer, self.now_s + wait_s)

    def next_due_s(self) -> float:
        """When the turn or somebody's grace ends; infinite if nothing is pending."""
        grace_ends_s = [self.lost_since_s[viewer] + self.grace_s for viewer in self.lost]
        pending_s = [end_s for end_s in grace_ends_s if end_s > self.now_s]
        if self.turns.ends_s is not None:
            pending_s.append(self.turns.ends_s)
        return min(pending_s, default=math.inf)

    # --- what can happen ---------------------------------------------------------------------

    @rule(viewer=VIEWERS)
    def connect(self, viewer: int) -> None:
        self.known.add(viewer)
        self.act(self.turns.connect, viewer)

    @rule(viewer=VIEWERS)
    def join(self, viewer: int) -> None:
        self.act(self.turns.join, viewer)

    @rule(viewer=VIEWERS)
    def leave(self, viewer: int) -> None:
        self.drives_by_s.pop(viewer, None)
        self.act(self.turns.leave, viewer)
        assert self.turns.place(viewer) is None

    @rule(viewer=VIEWERS)
    def lose(self, viewer: int) -> None:
        if viewer in self.known and viewer not in self.lost:
            self.lost.add(viewer)
            self.lost_since_s[viewer] = self.now_s
            self.drives_by_s.pop(viewer, None)
        self.act(self.turns.lost, viewer)

    @rule(viewer=VIEWERS)
    def come_back(self, viewer: int) -> None:
        self.lost.discard(viewer)
        self.act(self.turns.returned, viewer)

    @rule(viewer=VIEWERS)
    def close(self, viewer: int) -> None:
        self.drives_by_s.pop(viewer, None)
        self.known.discard(viewer)
        self.lost.discard(viewer)
        self.act(self.turns.gone, viewer)
        assert self.turns.place(viewer) is None

    @rule(pass_s=st.floats(0.0, 200.0))
    def time_passes(self, pass_s: float) -> None:
        """Tick at every deadline, as the control loop nearly does."""
        until_s = self.now_s + pass_s
        while (due_s := self.next_due_s()) <= until_s:
            self.now_s = due_s
            self.act(self.turns.tick)
            assert self.next_due_s() > due_s, "what was due is still to be done"
        self.now_s = until_s
        self.act(self.turns.tick)

    @rule(pass_s=st.floats(0.0, 500.0))
    def time_passes_unseen(self, pass_s: float) -> None:
        """One late tick after a gap, which delays every promise by no more than the gap."""
        self.now_s += pass_s
        for viewer in self.drives_by_s:
            self.drives_by_s[viewer] += pass_s
        self.act(self.turns.tick)

    # --- what always holds -------------------------------------------------------------------

    @invariant()
    def agrees_with_its_events(self) -> None:
        assert self.turns.operator == self.running
        assert self.turns.number == self.number

    @invariant()
    def everybody_has_one_role(self) -> None:
        line = [v for v in (self.turns.operator, *self.turns.queue) if v is not None]
        assert len(set(line)) == len(line)
        assert set(line) <= self.known
        assert {v for v in self.known if self.turns.is_lost(v)} == self.lost

    @invariant()
    def nobody_idles(self) -> None:
        """While somebody who is there waits, somebody drives."""
        if self.turns.operator is None:
            assert all(viewer in self.lost for viewer in self.turns.queue)

    @invariant()
    def no_turn_is_too_long(self) -> None:
        if self.turns.ends_s is not None:
            assert self.now_s < self.turns.ends_s <= self.now_s + self.turn_s

    @invariant()
    def no_grace_is_too_long(self) -> None:
        for viewer in (*self.turns.queue, self.turns.operator):
            if viewer in self.lost:
                assert self.now_s < self.lost_since_s[viewer] + self.grace_s


TestTurns = TurnsMachine.TestCase
TestTurns.settings = examples(150, stateful_step_count=60)
