"""What a host may add to first come, first served, case by case."""

from __future__ import annotations

from typing import Any

from wax.config.settings import TurnSettings
from wax.control.fairness import Person
from wax.control.turns import (
    Called,
    PassedOver,
    PlaceLost,
    TurnEnded,
    TurnRenewed,
    Turns,
    TurnStarted,
    Why,
)

A, B, C, D = 1, 2, 3, 4


def make(*viewers: int, invited: tuple[int, ...] = (), **settings: Any) -> Turns:
    """Make turns of 60 s that everybody has joined at 0 s, in this order."""
    turns = Turns(TurnSettings.model_validate(settings))
    for viewer in viewers:
        turns.connect(viewer, 0.0, Person(f"p{viewer}", is_invited=viewer in invited))
        turns.join(viewer, 0.0)
    return turns


# --- one person, one place -------------------------------------------------------------------


def test_two_pages_of_one_person_have_one_place() -> None:
    """The second page cannot join while the first waits or drives, and can once it has left."""
    turns = Turns(TurnSettings())
    for viewer in (A, B):
        turns.connect(viewer, 0.0, Person("ann"))
        turns.join(viewer, 0.0)
    assert (turns.operator, turns.queue) == (A, ())
    assert turns.has_place_elsewhere(B)
    turns.leave(A, 1.0)
    assert turns.join(B, 1.0) == (TurnStarted(2, B, 61.0),)


def test_those_who_wait_are_counted_by_address() -> None:
    """The room refuses the next one where too many of one address wait already."""
    turns = Turns(TurnSettings())
    for viewer in (A, B, C):
        turns.connect(viewer, 0.0, Person(str(viewer), address="school"))
        turns.join(viewer, 0.0)
    assert (turns.waiting_at("school"), turns.waiting_at("home")) == (2, 0)


# --- who goes first --------------------------------------------------------------------------


def test_the_invited_go_first() -> None:
    """They overtake strangers, and keep the order among themselves."""
    turns = make(A, B, C, D, invited=(C, D))
    assert turns.tick(60.0)[-1] == TurnStarted(2, C, 120.0)
    assert turns.tick(120.0)[-1] == TurnStarted(3, D, 180.0)


def test_who_has_just_driven_waits_even_if_invited() -> None:
    """A lone guest of the host does not drive twice in a row while a stranger waits."""
    turns = make(A, B, invited=(A,))
    assert turns.wait_s(B, 0.0) == 60.0
    assert turns.tick(60.0)[-1] == TurnStarted(2, B, 120.0)
    assert turns.tick(120.0)[-1] == TurnStarted(3, A, 180.0)


def test_a_wait_that_cannot_be_known_is_not_told() -> None:
    """Two who were invited may follow each other for as long as they like."""
    turns = make(A, B, C, invited=(A, B))
    assert turns.wait_s(B, 0.0) == 60.0
    assert turns.wait_s(C, 0.0) is None


def test_a_cool_down_lets_newcomers_pass() -> None:
    """B drove a moment ago, so C, who came later, goes first; then B."""
    turns = make(A, B, cooldown_s=300.0)
    turns.tick(60.0)
    turns.leave(B, 70.0)
    turns.join(B, 71.0)
    turns.connect(C, 72.0)
    turns.join(C, 73.0)
    assert turns.operator == A
    assert turns.wait_s(B, 73.0) is None
    assert turns.tick(130.0)[-1] == TurnStarted(4, C, 190.0)
    assert turns.tick(190.0)[-1] == TurnStarted(5, B, 250.0)


def test_nobody_is_kept_from_an_idle_robot() -> None:
    """Cool-down and shares let others go first, and there is no other."""
    turns = make(A, cooldown_s=300.0, max_share_per_person=0.1)
    turns.leave(A, 30.0)
    assert turns.join(A, 31.0) == (TurnStarted(2, A, 91.0),)
    assert turns.tick(91.0) == (TurnRenewed(2, A, 151.0),)


# --- the ready check -------------------------------------------------------------------------


def test_the_next_is_called_before_the_turn_is_over() -> None:
    """Ten seconds before; who answers drives at the turn's end."""
    turns = make(A, B, ready_s=10.0)
    assert turns.tick(49.9) == ()
    assert turns.tick(50.0) == (Called(B, 60.0),)
    assert turns.call is not None
    assert turns.call.viewer == B
    assert turns.answer(B, 55.0) == ()
    assert turns.call is None
    assert turns.tick(60.0) == (TurnEnded(1, A, Why.EXPIRED), TurnStarted(2, B, 120.0))


def test_who_has_just_joined_is_not_asked() -> None:
    """Pressing the button says enough, now and until the turn begins."""
    turns = make(A, ready_s=10.0)
    turns.connect(B, 45.0)
    turns.join(B, 45.0)
    assert turns.tick(50.0) == ()
    assert turns.tick(60.0)[-1] == TurnStarted(2, B, 120.0)


def test_who_is_called_goes_before_somebody_invited_who_comes_then() -> None:
    """And the one who comes is told to wait for that turn, too."""
    turns = make(A, B, ready_s=10.0, invited_first=True)
    turns.connect(C, 55.0, Person("carol", is_invited=True))
    turns.tick(55.0)
    turns.join(C, 56.0)
    assert turns.wait_s(C, 56.0) == 4.0 + 60.0
    turns.answer(B, 57.0)
    assert turns.tick(60.0)[-1] == TurnStarted(2, B, 120.0)
    assert turns.wait_s(C, 60.0) == 60.0


def test_an_absent_one_is_passed_over_once() -> None:
    """B misses the call: C drives, B keeps the place, is called again, and loses it then."""
    turns = make(A, B, C, ready_s=10.0)
    turns.tick(50.0)
    assert turns.tick(60.0) == (
        PassedOver(B),
        TurnEnded(1, A, Why.EXPIRED),
        Called(C, 70.0),
    )
    assert turns.operator is None
    assert turns.answer(C, 61.0) == (TurnStarted(2, C, 121.0),)
    assert turns.queue == (B, A)
    assert turns.tick(111.0) == (Called(B, 121.0),)
    events = turns.tick(121.0)
    assert events[0] == PlaceLost(B)
    assert turns.place(B) is None


def test_an_answer_after_a_missed_call_is_as_good_as_new() -> None:
    """B was away for a moment: once back, one more call may be missed."""
    turns = make(A, B, C, ready_s=10.0)
    turns.tick(50.0)
    turns.tick(60.0)
    turns.answer(B, 62.0)
    turns.answer(C, 63.0)
    assert turns.operator == C
    turns.tick(113.0)
    assert PassedOver(B) in turns.tick(123.0)


def test_the_only_one_who_waits_is_asked_twice() -> None:
    """Nobody else is there, so the second call follows at once."""
    turns = make(A, B, ready_s=10.0)
    turns.leave(A, 30.0)
    assert turns.call is not None
    assert turns.call.viewer == B
    assert turns.tick(40.0) == (PassedOver(B), Called(B, 50.0))
    assert turns.tick(50.0) == (PlaceLost(B),)
    assert turns.operator is None


def test_an_operator_goes_on_while_the_next_is_absent() -> None:
    """B alone waits and does not answer: A's turn renews."""
    turns = make(A, B, ready_s=10.0)
    turns.tick(50.0)
    assert turns.tick(60.0) == (PassedOver(B), TurnRenewed(1, A, 120.0))


def test_a_lost_one_is_not_absent() -> None:
    """Their call is withdrawn, the next is called, and the place stays through the grace time."""
    turns = make(A, B, C, ready_s=10.0)
    turns.tick(50.0)
    assert turns.lost(B, 52.0) == (Called(C, 62.0),)
    assert turns.place(B) == 1


# --- idle operators --------------------------------------------------------------------------


def test_an_idle_operator_yields_to_somebody_who_waits() -> None:
    """15 s without a command, and the next one drives; the idle one observes."""
    turns = make(A, B, idle_s=15.0)
    turns.drives(A, 5.0)
    assert turns.tick(19.9) == ()
    assert turns.tick(20.0) == (TurnEnded(1, A, Why.IDLE), TurnStarted(2, B, 80.0))
    assert turns.place(A) is None


def test_nobody_waits_for_an_idle_operator() -> None:
    """Alone one may look around as long as one likes; the time runs from when somebody waits."""
    turns = make(A, idle_s=15.0)
    assert turns.tick(40.0) == ()
    turns.connect(B, 41.0)
    turns.join(B, 41.0)
    assert turns.tick(55.9) == ()
    assert turns.tick(56.0)[0] == TurnEnded(1, A, Why.IDLE)


def test_who_cannot_drive_is_not_idle() -> None:
    """While a stop keeps them from it, and for 15 s after it."""
    turns = make(A, B, idle_s=15.0)
    turns.tick(10.0, is_kept=True)
    assert turns.tick(40.0, is_kept=True) == ()
    turns.tick(41.0)
    assert turns.tick(55.9) == ()
    assert turns.tick(56.0)[0] == TurnEnded(1, A, Why.IDLE)


# --- the clock stands still ------------------------------------------------------------------


def test_the_clock_stands_still_while_something_keeps_them_from_driving() -> None:
    """20 s of a stop make the turn end 20 s later."""
    turns = make(A, B)
    turns.tick(10.0, is_kept=True)
    assert turns.stands_left_s(20.0) == 50.0
    turns.tick(30.0)
    assert turns.stands_left_s(31.0) is None
    assert turns.ends_s == 80.0
    assert turns.tick(80.0)[0] == TurnEnded(1, A, Why.EXPIRED)


def test_it_stands_for_a_minute_at_most() -> None:
    """Who presses Stop again and again holds up the queue by no more than that."""
    turns = make(A, B)
    turns.tick(10.0, is_kept=True)
    assert turns.tick(119.0, is_kept=True) == ()
    assert turns.tick(120.0, is_kept=True)[0] == TurnEnded(1, A, Why.EXPIRED)


# --- the host --------------------------------------------------------------------------------


def test_the_host_ends_a_turn() -> None:
    """The next one drives, and whose turn it was observes."""
    turns = make(A, B)
    assert turns.end(10.0) == (TurnEnded(1, A, Why.ENDED), TurnStarted(2, B, 70.0))
    assert turns.place(A) is None
    assert make().end(10.0) == ()


def test_a_held_queue_starts_and_renews_nothing() -> None:
    """The turn ends in its time; nobody drives until the host lets the queue go on."""
    turns = make(A, B)
    assert turns.hold(True, 10.0) == ()
    assert turns.is_held
    assert turns.wait_s(B, 10.0) is None
    assert turns.tick(60.0) == (TurnEnded(1, A, Why.EXPIRED),)
    assert turns.tick(500.0) == ()
    assert turns.hold(False, 600.0) == (TurnStarted(2, B, 660.0),)


def test_a_lone_turn_ends_while_the_queue_is_held() -> None:
    """A hold is for the robot's rest, too: nobody renews."""
    turns = make(A)
    turns.hold(True, 10.0)
    assert turns.tick(60.0) == (TurnEnded(1, A, Why.EXPIRED),)
    assert turns.queue == (A,)


def test_a_hold_withdraws_the_call() -> None:
    """Who was called has missed nothing."""
    turns = make(A, B, ready_s=10.0)
    turns.tick(50.0)
    turns.hold(True, 51.0)
    assert turns.call is None
    assert PassedOver(B) not in turns.tick(70.0)
