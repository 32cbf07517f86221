"""What a host may add to first come, first served, case by case."""

from __future__ import annotations

from typing import Any

import pytest

from wax.config.turns import TurnSettings
from wax.control.fairness import Person
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
from wax.sentence import Sentence

STRANGER = Person("stranger", may_queue=False)
A, B, C, D = 1, 2, 3, 4


def make(*viewers: int, invited: tuple[int, ...] = (), **settings: Any) -> Turns:
    """Make turns of 60 s that everybody has joined at 0 s, in this order."""
    turns = Turns(TurnSettings.model_validate(settings))
    for viewer in viewers:
        turns.connect(viewer, 0.0, Person(f"p{viewer}", is_invited=viewer in invited))
        turns.join(viewer, 0.0)
    return turns


def test_nobody_acts_for_others() -> None:
    """An unknown viewer's answer, another's command and an observer's change have no effect."""
    turns = make(A, B, idle_s=10.0)
    assert turns.answer(C, 1.0) == ()
    turns.record_motion(B, 9.0)
    assert turns.tick(10.0)[0] == TurnEnded(1, A, Why.IDLE)
    turns.connect(C, 11.0)
    assert turns.update_person(C, STRANGER, 11.0) == ()


# --- one person, one place -------------------------------------------------------------------


def test_two_pages_of_one_person_have_one_place() -> None:
    """The second page cannot join while the first waits or drives, and can once it has left."""
    turns = Turns(TurnSettings())
    for viewer in (A, B):
        turns.connect(viewer, 0.0, Person("ann"))
        turns.join(viewer, 0.0)
    assert (turns.operator, turns.queue) == (A, ())
    assert turns.refusal(A) is None
    assert turns.refusal(B) == Sentence("queue.other_tab")
    turns.leave(A, 1.0)
    assert turns.join(B, 1.0) == (TurnStarted(2, B, 61.0),)


@pytest.mark.parametrize("join", ["ask", "auto"])
def test_those_who_wait_are_counted_by_address(join: str) -> None:
    """Once an address has its maximum of waiting viewers, only other addresses get places."""
    turns = crowd(join=join)
    assert (turns.operator, turns.queue) == (A, (B,))
    assert turns.refusal(C) == Sentence("queue.neighbours", {"n": 1})
    turns.connect(D, 0.0, Person("dan", address="home"))
    turns.join(D, 0.0)
    assert turns.queue == (B, D)


def test_who_has_just_driven_has_no_place_beyond_their_address() -> None:
    """An operator returns to the queue only if their address has room."""
    turns = crowd()
    turns.hold(True, 59.0)
    neighbours = Sentence("queue.neighbours", {"n": 1})
    assert turns.tick(60.0) == (TurnEnded(1, A, Why.EXPIRED), PlaceLost(A, neighbours))
    turns = crowd()
    assert turns.tick(60.0) == (TurnEnded(1, A, Why.EXPIRED), TurnStarted(2, B, 120.0))
    assert list(turns.queue) == [A]
    turns.connect(D, 61.0, Person("dan", address="home"))
    turns.join(D, 61.0)
    turns.leave(A, 61.0)
    turns.join(C, 61.0)
    assert turns.tick(120.0)[-1] == PlaceLost(B, neighbours)
    assert (turns.operator, list(turns.queue)) == (D, [C])


def crowd(*, join: str = "ask") -> Turns:
    """Have three of one address come and join, of whom one may wait."""
    raw = {"max_waiting_per_address": 1, "join": join}
    turns = Turns(TurnSettings.model_validate(raw))
    for viewer in (A, B, C):
        turns.connect(viewer, 0.0, Person(str(viewer), address="school"))
        turns.join(viewer, 0.0)
    return turns


# --- who may ---------------------------------------------------------------------------------


@pytest.mark.parametrize("join", ["ask", "auto"])
def test_who_may_not_queue_gets_no_place(join: str) -> None:
    """Somebody who may not queue gets no place by connecting, joining or coming back."""
    turns = Turns(TurnSettings.model_validate({"join": join}))
    turns.connect(A, 0.0, STRANGER)
    turns.join(A, 1.0)
    turns.lost(A, 2.0)
    turns.tick(30.0)
    turns.returned(A, 31.0)
    assert (turns.operator, turns.queue) == (None, ())
    assert turns.refusal(A) == Sentence("queue.not_invited")


def test_who_may_not_queue_any_more_loses_place_and_turn() -> None:
    """Losing the permission to queue ends place and turn at once, and the next one drives."""
    turns = make(A, B, C)
    why = Sentence("queue.not_invited")
    assert turns.update_person(B, STRANGER, 1.0) == (PlaceLost(B, why),)
    assert turns.update_person(A, STRANGER, 2.0) == (
        TurnEnded(1, A, Why.NOT_ALLOWED),
        TurnStarted(2, C, 62.0),
    )
    assert turns.update_person(A, STRANGER, 3.0) == ()
    assert turns.queue == ()


def test_who_moves_to_a_crowded_address_loses_the_place() -> None:
    """Moving to a full address costs the place, so that nobody can bypass its maximum."""
    turns = crowd()
    turns.connect(D, 0.0, Person("dan", address="home"))
    turns.join(D, 0.0)
    moved = Person("dan", address="school")
    neighbours = Sentence("queue.neighbours", {"n": 1})
    assert turns.connect(D, 1.0, moved) == (PlaceLost(D, neighbours),)


# --- who waits elsewhere ---------------------------------------------------------------------


def test_no_turn_begins_for_somebody_elsewhere() -> None:
    """A connected viewer drives instead; a viewer who connects in time gets the next turn."""
    turns = away(B)
    assert list(turns.queue) == [B, C]
    assert turns.leave(A, 10.0) == (TurnEnded(1, A, Why.LEFT), TurnStarted(2, C, 70.0))
    assert list(turns.queue) == [B]
    assert turns.wait_s(B, 60.0) == 10.0
    turns.connect(B, 60.0, Person("p2"))
    assert turns.tick(70.0)[-1] == TurnStarted(3, B, 130.0)


def test_who_never_comes_loses_the_place() -> None:
    """A viewer who never connects loses the place at the next turn, or on time if nobody drives."""
    turns = away(B)
    turns.leave(A, 10.0)
    assert turns.tick(70.0) == (PlaceLost(B), TurnRenewed(2, C, 130.0))
    turns = away(A, B)
    assert (turns.operator, turns.queue) == (C, (A, B))
    turns.leave(C, 1.0)
    assert turns.tick(COMES_S - 0.1) == ()
    assert turns.tick(COMES_S) == (PlaceLost(A),)
    assert turns.tick(2 * COMES_S) == (PlaceLost(B),)


def test_turns_that_end_early_cost_nobody_elsewhere_their_place() -> None:
    """Early ends of turns cost nobody elsewhere their place, since they need time to connect."""
    turns = away(B)
    turns.connect(D, 0.0)
    turns.join(D, 0.0)
    turns.leave(A, 10.0)
    turns.leave(C, 12.0)
    assert (turns.operator, turns.queue) == (D, (B,))


def test_an_operator_elsewhere_is_lost() -> None:
    """An operator who goes elsewhere counts as lost: the turn is kept for the grace time only."""
    turns = make(A, B)
    turns.connect(A, 1.0, is_here=False)
    assert turns.is_lost(A)
    turns.connect(A, 5.0, is_here=False)
    grace_s = TurnSettings().grace_s
    assert turns.tick(1.0 + grace_s)[0] == TurnEnded(1, A, Why.GONE)


def test_who_is_elsewhere_is_called_before_their_turn() -> None:
    """A viewer elsewhere is called, so that their page connects; if it does not, another drives."""
    turns = away(B, ready_s=20.0)
    assert turns.tick(40.0) == (Called(B, 60.0),)
    turns.answer(B, 45.0)
    turns.answer(C, 50.0)
    assert turns.tick(60.0)[-1] == TurnStarted(2, C, 120.0)


def away(*elsewhere: int, **settings: float) -> Turns:
    """Have three join at 0 s, some of whom wait elsewhere."""
    turns = Turns(TurnSettings.model_validate(settings))
    for viewer in (A, B, C):
        turns.connect(viewer, 0.0, Person(f"p{viewer}"), is_here=viewer not in elsewhere)
        turns.join(viewer, 0.0)
    return turns


# --- who goes first --------------------------------------------------------------------------


def test_the_invited_go_first() -> None:
    """Invited people go before strangers, and keep the order among themselves."""
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
    """The wait is unknown to a stranger while two invited people may alternate."""
    turns = make(A, B, C, invited=(A, B))
    assert turns.wait_s(B, 0.0) == 60.0
    assert turns.wait_s(C, 0.0) is None


@pytest.mark.parametrize(
    ("queue", "turns_before"), [((A, C, B), 2), ((A, C, D, B), 4), ((A, D, C, B), 4)]
)
def test_a_lone_guest_drives_before_each_stranger(
    queue: tuple[int, ...], turns_before: int
) -> None:
    """C, the only one invited, may drive before D and again before B, and each wait says so."""
    turns = make(*queue, invited=(C,))
    assert turns.wait_s(B, 0.0) == turns_before * 60.0


def test_where_the_invited_do_not_go_first_they_wait_like_others() -> None:
    """Each waits for everybody who came before."""
    turns = make(A, B, C, invited=(C,), invited_first=False)
    assert [turns.wait_s(viewer, 0.0) for viewer in (B, C)] == [60.0, 120.0]


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
    """Cool-down and shares do not keep the only waiting viewer from driving."""
    turns = make(A, cooldown_s=300.0, max_share_per_person=0.1)
    turns.leave(A, 30.0)
    assert turns.join(A, 31.0) == (TurnStarted(2, A, 91.0),)
    assert turns.tick(91.0) == (TurnRenewed(2, A, 151.0),)


# --- the ready check -------------------------------------------------------------------------


def test_the_next_is_called_before_the_turn_is_over() -> None:
    """The next viewer is called ten seconds before the turn ends, and drives if they answer."""
    turns = make(A, B, ready_s=10.0)
    assert turns.tick(49.9) == ()
    assert turns.tick(50.0) == (Called(B, 60.0),)
    assert turns.call is not None
    assert turns.call.viewer == B
    assert turns.answer(B, 55.0) == ()
    assert turns.call is None
    assert turns.tick(60.0) == (TurnEnded(1, A, Why.EXPIRED), TurnStarted(2, B, 120.0))


def test_who_leaves_is_called_no_more() -> None:
    """Somebody who leaves while they are called is not passed over, for they do not wait."""
    turns = make(A, B, ready_s=10.0)
    turns.tick(50.0)
    assert turns.leave(B, 51.0) == ()
    assert turns.tick(60.0) == (TurnRenewed(1, A, 120.0),)


def test_who_has_just_joined_is_not_asked() -> None:
    """A viewer who has just joined is not called."""
    turns = make(A, ready_s=10.0)
    turns.connect(B, 45.0)
    turns.join(B, 45.0)
    assert turns.tick(50.0) == ()
    assert turns.tick(60.0)[-1] == TurnStarted(2, B, 120.0)


def test_who_is_called_goes_before_somebody_invited_who_comes_then() -> None:
    """A called viewer drives before an invited one who joins later, whose wait includes that."""
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
    """After an answer a viewer may miss one call again."""
    turns = make(A, B, C, ready_s=10.0)
    turns.tick(50.0)
    turns.tick(60.0)
    turns.answer(B, 62.0)
    turns.answer(C, 63.0)
    assert turns.operator == C
    turns.tick(113.0)
    assert PassedOver(B) in turns.tick(123.0)


def test_the_only_one_who_waits_is_asked_twice() -> None:
    """If nobody else waits, the second call follows at once."""
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
    """A lost viewer's call is cancelled and the next is called; they keep their place for grace."""
    turns = make(A, B, C, ready_s=10.0)
    turns.tick(50.0)
    assert turns.lost(B, 52.0) == (Called(C, 62.0),)
    assert turns.place(B) == 1


# --- idle operators --------------------------------------------------------------------------


def test_an_idle_operator_yields_to_somebody_who_waits() -> None:
    """15 s without a command, and the next one drives; the idle one observes."""
    turns = make(A, B, idle_s=15.0)
    turns.record_motion(A, 5.0)
    assert turns.tick(19.9) == ()
    assert turns.tick(20.0) == (TurnEnded(1, A, Why.IDLE), TurnStarted(2, B, 80.0))
    assert turns.place(A) is None


def test_nobody_waits_for_an_idle_operator() -> None:
    """The idle time starts only when somebody else waits."""
    turns = make(A, idle_s=15.0)
    assert turns.tick(40.0) == ()
    turns.connect(B, 41.0)
    turns.join(B, 41.0)
    assert turns.tick(55.9) == ()
    assert turns.tick(56.0)[0] == TurnEnded(1, A, Why.IDLE)


def test_who_cannot_drive_is_not_idle() -> None:
    """An operator kept from driving by a stop is not idle until 15 s after it."""
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
    assert turns.paused_left_s(20.0) == 50.0
    turns.tick(30.0)
    assert turns.paused_left_s(31.0) is None
    assert turns.ends_s == 80.0
    assert turns.tick(80.0)[0] == TurnEnded(1, A, Why.EXPIRED)


def test_who_is_next_is_called_as_soon_as_it_goes_on() -> None:
    """When the clock resumes shortly before the turn's end, the next viewer is called at once."""
    turns = make(A, ready_s=10.0)
    turns.tick(55.0, is_kept=True)
    turns.connect(B, 56.0)
    turns.join(B, 56.0)
    assert turns.tick(69.0, is_kept=True) == ()
    assert turns.tick(70.0) == (Called(B, 80.0),)


def test_it_stands_for_a_minute_at_most() -> None:
    """Repeated Stops pause a turn for a minute at most."""
    turns = make(A, B)
    turns.tick(10.0, is_kept=True)
    assert turns.tick(119.0, is_kept=True) == ()
    assert turns.tick(120.0, is_kept=True)[0] == TurnEnded(1, A, Why.EXPIRED)


# --- the host --------------------------------------------------------------------------------


def test_the_host_ends_a_turn() -> None:
    """When the host ends a turn, the next one drives and its operator observes."""
    turns = make(A, B)
    assert turns.end(10.0) == (TurnEnded(1, A, Why.ENDED), TurnStarted(2, B, 70.0))
    assert turns.place(A) is None
    assert make().end(10.0) == ()


def test_a_held_queue_starts_and_renews_nothing() -> None:
    """The turn ends in its time; nobody drives until the host lets the queue go on."""
    turns = make(A, B)
    assert turns.hold(True, 10.0) == ()
    assert turns.wait_s(B, 10.0) is None
    assert turns.tick(60.0) == (TurnEnded(1, A, Why.EXPIRED),)
    assert turns.tick(500.0) == ()
    assert turns.hold(False, 600.0) == (TurnStarted(2, B, 660.0),)


def test_a_lone_turn_ends_while_the_queue_is_held() -> None:
    """While the queue is held, even a lone operator's turn ends without renewal."""
    turns = make(A)
    turns.hold(True, 10.0)
    assert turns.tick(60.0) == (TurnEnded(1, A, Why.EXPIRED),)
    assert list(turns.queue) == [A]


def test_a_hold_withdraws_the_call() -> None:
    """A hold cancels the call, which does not count as missed."""
    turns = make(A, B, ready_s=10.0)
    turns.tick(50.0)
    turns.hold(True, 51.0)
    assert turns.call is None
    assert PassedOver(B) not in turns.tick(70.0)
