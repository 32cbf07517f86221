"""The queue and the turns, case by case."""

from __future__ import annotations

import pytest

from wax.config.turns import TurnSettings
from wax.control.turns import PlaceLost, TurnEnded, TurnRenewed, Turns, TurnStarted, Why

A, B, C = 1, 2, 3


def make(*viewers: int, join: str = "ask", turn_s: float = 60.0, grace_s: float = 3.0) -> Turns:
    """Make turns in which everybody has connected and joined at 0 s, in this order."""
    settings = TurnSettings.model_validate({"turn_s": turn_s, "grace_s": grace_s, "join": join})
    turns = Turns(settings)
    for viewer in viewers:
        turns.connect(viewer, 0.0)
        turns.join(viewer, 0.0)
    return turns


def test_nobody_drives_at_first() -> None:
    """Before anybody joins there is no operator and no end, and the turn number is 0."""
    turns = make()
    assert turns.connect(A, 1.0) == ()
    assert (turns.operator, turns.number, turns.ends_s, turns.queue) == (None, 0, None, ())
    assert turns.tick(10_000.0) == ()


def test_first_to_join_drives_at_once() -> None:
    """A viewer who joins an empty queue drives for turn_s from that moment."""
    turns = make()
    turns.connect(A, 1.0)
    assert turns.join(A, 2.0) == (TurnStarted(1, A, 62.0),)
    assert (turns.operator, turns.number, turns.ends_s) == (A, 1, 62.0)


def test_next_drives_and_the_operator_goes_to_the_end() -> None:
    """At the end of a turn the first in the queue drives, and the operator is its last."""
    turns = make(A, B, C)
    assert turns.tick(59.999) == ()
    assert turns.tick(60.0) == (TurnEnded(1, A, Why.EXPIRED), TurnStarted(2, B, 120.0))
    assert list(turns.queue) == [C, A]


def test_lone_turn_renews() -> None:
    """Alone in the queue, the turn goes on under its number, and its end moves by turn_s."""
    turns = make(A)
    assert turns.tick(60.02) == (TurnRenewed(1, A, 120.0),)
    assert (turns.operator, turns.number) == (A, 1)


def test_lone_turn_is_not_cut_short() -> None:
    """A viewer who joins during a renewed turn waits for its rest; it does not renew again."""
    turns = make(A)
    turns.connect(B, 0.0)
    turns.tick(60.0)
    assert turns.join(B, 90.0) == ()
    assert turns.wait_s(B, 90.0) == 30.0
    assert turns.tick(119.0) == ()
    assert turns.tick(120.0) == (TurnEnded(1, A, Why.EXPIRED), TurnStarted(2, B, 180.0))


def test_leaving_hands_over_at_once() -> None:
    """An operator who leaves observes, and the next drives from that moment."""
    turns = make(A, B)
    assert turns.leave(A, 10.0) == (TurnEnded(1, A, Why.LEFT), TurnStarted(2, B, 70.0))
    assert turns.place(A) is None


def test_leaving_the_queue() -> None:
    """A viewer who leaves the queue gives up their place, and those behind move up."""
    turns = make(A, B, C)
    assert turns.leave(B, 1.0) == ()
    assert [turns.place(v) for v in (A, B, C)] == [0, None, 1]


def test_last_to_leave_leaves_nobody() -> None:
    """When the only one leaves nobody drives, and the number stays."""
    turns = make(A)
    assert turns.leave(A, 10.0) == (TurnEnded(1, A, Why.LEFT),)
    assert (turns.operator, turns.number, turns.ends_s) == (None, 1, None)


def test_same_viewer_after_a_gap_gets_a_new_number() -> None:
    """The number rises with every turn that starts, also for the same viewer."""
    turns = make(A)
    turns.leave(A, 10.0)
    assert turns.join(A, 11.0) == (TurnStarted(2, A, 71.0),)


def test_what_changes_nothing() -> None:
    """Joining or connecting twice, an observer's leaving, and strangers change nothing."""
    turns = make(A, B)
    turns.connect(C, 1.0)
    before = (turns.operator, turns.queue, turns.ends_s, turns.number)
    nothing = [
        turns.join(A, 2.0),
        turns.join(B, 2.0),
        turns.connect(A, 2.0),
        turns.leave(C, 2.0),
        turns.join(99, 2.0),
        turns.leave(99, 2.0),
        turns.lost(99, 2.0),
        turns.returned(99, 2.0),
        turns.returned(C, 2.0),
        turns.gone(99, 2.0),
        turns.join(99, 2.0),
    ]
    assert nothing == [()] * len(nothing)
    assert (turns.operator, turns.queue, turns.ends_s, turns.number) == before
    assert not turns.is_lost(99)


def test_short_loss_keeps_the_turn() -> None:
    """A lost operator who returns within grace drives on; the clock of their turn ran on."""
    turns = make(A, B)
    assert turns.lost(A, 10.0) == ()
    assert turns.operator == A
    assert turns.is_lost(A)
    assert turns.returned(A, 12.9) == ()
    assert not turns.is_lost(A)
    assert turns.ends_s == 60.0
    assert turns.tick(59.9) == ()


def test_long_loss_ends_the_turn() -> None:
    """An operator who is lost for grace_s gives up turn and place."""
    turns = make(A, B)
    turns.lost(A, 10.0)
    assert turns.tick(12.99) == ()
    assert turns.tick(13.0) == (TurnEnded(1, A, Why.GONE), TurnStarted(2, B, 73.0))
    assert turns.place(A) is None
    assert turns.is_lost(A)


def test_losing_twice_does_not_prolong_grace() -> None:
    """The grace time starts with the first report of the loss."""
    turns = make(A, B)
    turns.lost(A, 10.0)
    turns.lost(A, 12.0)
    assert turns.tick(13.0)[0] == TurnEnded(1, A, Why.GONE)
    assert turns.lost(A, 14.0) == ()
    assert turns.tick(72.9) == ()
    assert turns.ends_s == 73.0


def test_waiting_viewer_keeps_their_place_for_grace() -> None:
    """A waiting viewer who is lost keeps their place for grace_s, then it is given up."""
    turns = make(A, B, C)
    turns.lost(B, 10.0)
    assert turns.place(B) == 1
    assert turns.tick(13.0) == (PlaceLost(B),)
    assert list(turns.queue) == [C]


def test_lost_observer_has_nothing_to_lose() -> None:
    """The end of an observer's grace is no event."""
    turns = make(A)
    turns.connect(B, 0.0)
    turns.lost(B, 1.0)
    assert turns.tick(4.0) == ()
    assert turns.is_lost(B)


def test_turn_passes_over_the_lost() -> None:
    """A turn goes to the first connected viewer; lost ones keep their places in front."""
    turns = make(A, B, C)
    turns.lost(B, 59.0)
    assert turns.tick(60.0) == (TurnEnded(1, A, Why.EXPIRED), TurnStarted(2, C, 120.0))
    assert list(turns.queue) == [B, A]
    assert turns.returned(B, 61.0) == ()
    assert turns.tick(120.0)[1] == TurnStarted(3, B, 180.0)


def test_turn_renews_if_only_lost_viewers_wait() -> None:
    """While everybody who waits is lost, the operator drives on."""
    turns = make(A, B)
    turns.lost(B, 59.0)
    assert turns.tick(60.0) == (TurnRenewed(1, A, 120.0),)
    assert list(turns.queue) == [B]


def test_lost_operator_at_the_end_of_their_turn() -> None:
    """A turn that ends while its operator is lost is handed over; they wait at the end."""
    turns = make(A, B)
    turns.lost(A, 59.0)
    assert turns.tick(60.0) == (TurnEnded(1, A, Why.EXPIRED), TurnStarted(2, B, 120.0))
    assert list(turns.queue) == [A]
    assert turns.tick(62.0) == (PlaceLost(A),)


def test_nobody_drives_when_all_are_lost() -> None:
    """If everybody is lost when a turn ends, nobody drives until the first one returns."""
    turns = make(A, B)
    turns.lost(A, 59.0)
    turns.lost(B, 59.5)
    assert turns.tick(60.0) == (TurnEnded(1, A, Why.EXPIRED),)
    assert turns.operator is None
    assert list(turns.queue) == [B, A]
    assert turns.wait_s(B, 60.0) is None
    assert turns.returned(A, 61.0) == (TurnStarted(2, A, 121.0),)
    assert list(turns.queue) == [B]


def test_grace_goes_before_the_end_of_the_turn() -> None:
    """An operator whose grace and turn end at the same instant loses their place."""
    turns = make(A, B)
    turns.lost(A, 57.0)
    assert turns.tick(60.0)[0] == TurnEnded(1, A, Why.GONE)
    assert list(turns.queue) == []


def test_no_grace_at_all() -> None:
    """With grace_s = 0 a lost connection gives up the turn at once."""
    turns = make(A, B, grace_s=0.0)
    assert turns.lost(A, 5.0) == (TurnEnded(1, A, Why.GONE), TurnStarted(2, B, 65.0))


def test_return_after_grace_is_a_new_beginning() -> None:
    """A viewer who returns after their grace time observes, and can join at the end again."""
    turns = make(A, B)
    turns.lost(A, 10.0)
    turns.tick(14.0)
    assert turns.join(A, 15.0) == ()
    assert turns.place(A) is None
    assert turns.returned(A, 16.0) == ()
    assert (turns.place(A), turns.is_lost(A)) == (None, False)
    turns.join(A, 17.0)
    assert turns.place(A) == 1


def test_gone_hands_over_at_once() -> None:
    """A closed operator's turn is handed over, and they are forgotten."""
    turns = make(A, B, C)
    turns.lost(A, 1.0)
    assert turns.gone(A, 2.0) == (TurnEnded(1, A, Why.GONE), TurnStarted(2, B, 62.0))
    assert turns.gone(C, 2.0) == ()
    assert list(turns.queue) == []
    assert not turns.is_lost(A)
    assert turns.join(A, 3.0) == ()
    assert turns.tick(61.9) == ()
    assert turns.ends_s == 62.0


def test_gone_after_grace_is_forgotten() -> None:
    """A viewer who is closed after their grace time leaves nothing behind."""
    turns = make(A)
    turns.lost(A, 1.0)
    turns.tick(5.0)
    turns.gone(A, 6.0)
    assert not turns.is_lost(A)
    assert turns.returned(A, 7.0) == ()
    assert turns.join(A, 7.0) == ()


def test_auto_join() -> None:
    """With join = auto everybody queues on connecting; those who leave observe until they join."""
    turns = make(join="auto")
    assert turns.connect(A, 0.0) == (TurnStarted(1, A, 60.0),)
    turns.connect(B, 0.0)
    assert list(turns.queue) == [B]
    turns.leave(B, 1.0)
    turns.lost(B, 2.0)
    turns.returned(B, 3.0)
    assert list(turns.queue) == []
    turns.join(B, 4.0)
    assert list(turns.queue) == [B]


def test_auto_join_after_grace() -> None:
    """With join = auto, coming back after grace is like connecting: at the end of the queue."""
    turns = make(A, B, C, join="auto")
    turns.lost(B, 1.0)
    turns.tick(5.0)
    turns.returned(B, 6.0)
    assert list(turns.queue) == [C, B]


@pytest.mark.parametrize("late_s", [0.0, 0.5, 59.9, 60.0, 140.0])
def test_late_tick_gives_whole_turns(late_s: float) -> None:
    """However late a tick comes, the next turn starts then and lasts turn_s."""
    turns = make(A, B)
    now_s = 60.0 + late_s
    assert turns.tick(now_s) == (TurnEnded(1, A, Why.EXPIRED), TurnStarted(2, B, now_s + 60.0))


@pytest.mark.parametrize(
    ("now_s", "ends_s"), [(60.0, 120.0), (119.9, 120.0), (120.0, 180.0), (260.0, 300.0)]
)
def test_late_renewal_keeps_the_rhythm(now_s: float, ends_s: float) -> None:
    """A renewal that comes late is one event, and its end stays on the turns' grid."""
    turns = make(A)
    assert turns.tick(now_s) == (TurnRenewed(1, A, ends_s),)


def test_renewal_is_one_event_whatever_is_rounded() -> None:
    """A renewal that falls on the end of a later turn is one event, and ends after now."""
    turns = make(turn_s=1.1)
    turns.connect(A, 268.729)
    turns.join(A, 268.729)
    [renewed] = turns.tick(272.029)
    assert isinstance(renewed, TurnRenewed)
    assert renewed.ends_s == pytest.approx(273.129)


def test_late_tick_replays_in_order() -> None:
    """What fell due meanwhile happens in the order of its time, also in a late tick."""
    turns = make(A, B, C)
    turns.lost(B, 58.0)
    turns.lost(A, 59.0)
    assert turns.tick(260.0) == (
        TurnEnded(1, A, Why.EXPIRED),
        PlaceLost(B),
        PlaceLost(A),
        TurnStarted(2, C, 320.0),
    )


def test_any_call_catches_up_first() -> None:
    """A call after a deadline acts on the state after that deadline."""
    turns = make(A, B)
    assert turns.leave(A, 61.0) == (TurnEnded(1, A, Why.EXPIRED), TurnStarted(2, B, 121.0))
    assert turns.place(A) is None


def test_wait_is_honest() -> None:
    """The estimate is the rest of this turn and a whole turn for everybody before."""
    turns = make(A, B, C)
    turns.connect(4, 0.0)
    assert [turns.wait_s(v, 20.0) for v in (A, B, C, 4)] == [0.0, 40.0, 100.0, None]
    turns.lost(C, 20.0)
    assert turns.wait_s(C, 20.0) is None
    assert turns.wait_s(B, 61.0) == 0.0
