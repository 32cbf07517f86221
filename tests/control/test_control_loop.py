"""The control loop on a fake clock, with a driver that records its calls."""

from __future__ import annotations

import asyncio
import itertools
import math
from contextlib import asynccontextmanager, suppress
from dataclasses import replace
from types import SimpleNamespace
from typing import TYPE_CHECKING

import pytest
from structlog.testing import capture_logs
from tests.control.rig import AGILE, AHEAD, A, B, Bench, FakeDriver, FakeOperators, make_loop
from tests.turned_clock import TurnedClock

from wax.clock import SystemClock
from wax.config.drive import DriveSettings
from wax.config.robot import RobotSettings
from wax.control.command import Command
from wax.control.listener import Listener
from wax.control.reasons import ABOARD, Hold, Limit, Refusal, stopped_by
from wax.control.safe_driver import NOT_CONNECTED
from wax.control.stop_latch import LatchedStop
from wax.control.turns import PlaceLost, TurnEnded, TurnRenewed, TurnStarted
from wax.driver.checks import NO_ANSWER
from wax.driver.interface import STANDSTILL, Aboard, Limits, RobotState, Twist
from wax.sentence import Sentence, says

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from wax.control.loop import ControlLoop
    from wax.control.stop_latch import Releaser


class FakeChair(FakeDriver):
    """A robot with a person aboard."""

    is_operated: bool | None = None

    def tell_passenger(self, *, is_operated: bool) -> None:
        self.is_operated = is_operated


@pytest.fixture
def bench() -> Bench:
    """Two viewers in the queue, the first of them drives; the loop has taken a step."""
    bench = Bench()
    bench.enter(A, B)
    bench.step()
    return bench


# --- the person aboard --------------------------------------------------------------------------


def test_the_person_aboard_takes_the_robot_from_its_operator(bench: Bench) -> None:
    """Once the person aboard takes over, the operator's commands move nothing, with a reason."""
    bench.drive()
    bench.driver.now = replace(bench.driver.now, aboard=Aboard("hand", 0.0))
    assert ("stop", 1) in bench.step()
    assert bench.loop.is_taken
    assert bench.statuses[-1] == (A, False, ABOARD["hand"])
    assert not bench.moves()
    bench.driver.now = replace(bench.driver.now, aboard=Aboard("free"))
    assert not bench.moves()
    assert not bench.loop.is_taken
    assert bench.statuses[-1] == (A, False, Hold.ABOARD.value)
    bench.drive()


@pytest.mark.parametrize(
    ("max_fraction", "aboard", "left"),
    [
        (1.0, None, 1.0),
        (1.0, Aboard("free"), 1.0),
        (1.0, Aboard("free", 0.43), 0.45),
        (0.5, None, 0.5),
        (0.5, Aboard("free", 0.4), 0.2),
        (1.0, Aboard("free", 0.0), 0.0),
    ],
)
def test_an_operator_is_told_what_is_left_of_their_speed(
    bench: Bench, max_fraction: float, aboard: Aboard | None, left: float
) -> None:
    """Limits and the person aboard lower the reported share of the speed, in twentieths."""
    bench.operators.fraction = max_fraction
    bench.driver.now = replace(bench.driver.now, aboard=aboard)
    for linear in (0.0, 1.0):
        bench.step()
        bench.offer(linear)
    bench.step()
    assert bench.shares[-1] == left


def test_the_clock_of_a_turn_stands_still_while_the_person_aboard_drives(bench: Bench) -> None:
    """While the person aboard drives, the operator's turn does not run out."""
    bench.driver.now = replace(bench.driver.now, aboard=Aboard("stopped", 0.0))
    bench.step()
    bench.step()
    left_s = bench.turns.paused_left_s(bench.clock.time_s)
    assert left_s is not None
    bench.step(20.0)
    assert bench.turns.paused_left_s(bench.clock.time_s) == left_s


class FakeTimer(FakeDriver):
    """A driver that is told when a command expires."""

    end_s: float | None = None

    def set_deadline(self, end_s: float) -> None:
        self.end_s = end_s


def test_a_driver_is_told_when_the_command_ends() -> None:
    """A command expires by its age plus the link's delay after it was sent; standstill never."""
    driver = FakeTimer()
    bench = Bench(driver=driver)
    bench.enter(A)
    bench.step()
    bench.drive()
    assert driver.end_s == pytest.approx(bench.clock.time_s - 0.02 + 0.25)
    bench.loop.press_stop(says("Bob"))
    bench.step()
    assert driver.end_s == math.inf


@pytest.mark.parametrize("way", [(1.0, 0.0), (0.0, -1.0), (1.0, 1.0)])
def test_a_key_reaches_the_driver_before_the_next_tick(way: tuple[float, float]) -> None:
    """A new direction is sent as its command arrives: ahead, sideways and in between alike."""
    bench = Bench(limits=Limits(0.5, 1.0, lateral_mps=0.5))
    bench.enter(A)
    bench.step()
    bench.offer()
    bench.step()
    bench.clock.time_s += 0.02
    ahead, left = way
    command = replace(bench.command(), linear=ahead, lateral=left, held=True)
    assert bench.loop.handle_command(A, command) is None
    ((_, told, _),) = [call for call in bench.driver.take() if call[0] == "apply"]
    assert isinstance(told, Twist)
    share = 0.5 / math.hypot(*way)
    assert (told.linear_mps, told.lateral_mps) == pytest.approx((ahead * share, left * share))


def test_a_chair_is_told_whether_somebody_may_drive() -> None:
    """Nobody may drive while the operator is lost, a stop is latched, or the host holds it."""
    chair = FakeChair()
    bench = Bench(driver=chair)
    bench.step()
    assert chair.is_operated is False
    bench.enter(A)
    bench.step()
    assert chair.is_operated is True
    bench.loop.lost(A)
    bench.step()
    assert chair.is_operated is False
    bench.loop.returned(A)
    stop = bench.loop.press_stop("Bob")
    bench.step()
    assert chair.is_operated is False
    assert bench.loop.release_stop("host", stop, None) is None
    bench.step()
    assert chair.is_operated is True
    bench.operators.on_hold = "The host has switched picture and sound off."
    bench.step()
    assert chair.is_operated is False


# --- the beat ---------------------------------------------------------------------------------


def test_beat_goes_on_without_operator() -> None:
    """While nobody drives, every step sends standstill, and no status is reported."""
    bench = Bench()
    bench.step()
    assert bench.step() == [("apply", STANDSTILL, 0)]
    assert bench.statuses == []
    assert bench.operators.asked_what_they_see == set()


def test_beat_repeats_the_set_point(bench: Bench) -> None:
    """While the command is fresh, every step sends its set-point again."""
    bench.drive()
    assert bench.step() == [("apply", AHEAD, 1)]
    assert bench.step() == [("apply", AHEAD, 1)]


def test_silence_stops_the_robot(bench: Bench) -> None:
    """When commands cease the robot is stopped, and the operator is told why, once."""
    bench.drive()
    for _ in range(11):  # until 0.24 s after it was sent: 0.15 s and the link's 0.1 s are allowed
        assert bench.step() == [("apply", AHEAD, 1)]
    assert bench.step() == [("stop", 1), ("apply", STANDSTILL, 1)]
    assert bench.step() == [("apply", STANDSTILL, 1)]
    assert bench.statuses[-2:] == [(A, True, None), (A, False, Refusal.TOO_OLD.value)]


def test_change_goes_out_at_once(bench: Bench) -> None:
    """A command that changes the set-point is sent to the robot at once, not at the next tick."""
    bench.offer()
    bench.step()
    bench.clock.time_s += 0.006
    bench.offer(1.0)
    assert bench.driver.take() == [("apply", AHEAD, 1)]


def test_repeated_command_waits_for_the_beat(bench: Bench) -> None:
    """A command that changes nothing sends no extra set-point."""
    bench.drive()
    bench.clock.time_s += 0.006
    bench.offer(1.0)
    assert bench.driver.take() == []


def test_changes_keep_their_distance(bench: Bench) -> None:
    """Within 5 ms of the last set-point a change waits for the next step."""
    bench.offer()
    bench.step()
    bench.clock.time_s += 0.004
    bench.offer(1.0)
    assert bench.driver.take() == []
    assert bench.step(0.002) == [("apply", AHEAD, 1)]


def test_the_distance_is_kept_and_no_more() -> None:
    """A change just 5 ms after the last set-point goes out at once."""
    bench = Bench()
    bench.clock.time_s = 0.0  # where five milliseconds later is not rounded
    bench.enter(A)
    bench.loop.step(0.0)
    bench.offer()
    bench.driver.take()
    bench.clock.time_s = 0.005
    bench.offer(1.0)
    assert bench.driver.take() == [("apply", AHEAD, 1)]


def test_what_is_refused_makes_no_set_point(bench: Bench) -> None:
    """However often another viewer sends, the robot gets its set-points only when they are due."""
    bench.drive()
    bench.clock.time_s += 0.235  # the operator's last word is too old by now
    bench.driver.take()
    assert bench.offer(1.0, viewer=B) is Refusal.NOT_YOUR_TURN
    assert bench.driver.take() == []
    assert ("stop", 1) in bench.step(0.001)


def test_blocked_loop_stops_the_robot_first(bench: Bench) -> None:
    """After more than 200 ms without a tick the robot is stopped and neutral must come first."""
    bench.drive()
    assert bench.step(0.221) == [("stop", 1), ("apply", STANDSTILL, 1)]
    assert bench.statuses[-1] == (A, False, Hold.LATE.value)
    assert not bench.moves()
    bench.drive()
    assert bench.loop.counts()["control.late"] == 1
    assert bench.loop.counts()["control.latest_ms"] == 201.0


def test_blocked_loop_is_noticed_by_a_command_too(bench: Bench) -> None:
    """If a command wakes a blocked loop, the robot is still stopped before the command counts."""
    bench.drive()
    bench.clock.time_s += 0.5
    bench.driver.take()
    bench.offer(0.5)
    assert bench.driver.take() == [("stop", 1), ("apply", STANDSTILL, 1)]


def test_the_beat_is_seen_from_outside(bench: Bench) -> None:
    """Monitoring can read when the last set-point was sent, and how late all ticks were."""
    before = sum(bench.loop.lateness.counts)
    bench.step()
    assert bench.loop.stepped_s == bench.clock.time_s
    bench.step(0.05)
    assert sum(bench.loop.lateness.counts) == before + 2
    assert bench.loop.lateness.sum_s == pytest.approx(0.03)


def test_slightly_late_beat_is_let_be(bench: Bench) -> None:
    """A tick up to 200 ms late does not interrupt driving, and the schedule does not drift."""
    bench.drive()
    assert bench.step(0.219) == [("apply", AHEAD, 1)]
    assert bench.loop.counts()["control.latest_ms"] == 199
    bench.step(0.001)  # on the schedule again
    bench.step(0.219)
    assert bench.loop.counts()["control.latest_ms"] == 199


@pytest.mark.parametrize(
    ("ttl_s", "let_be_s"), [(None, 0.2), (1.0, 0.2), (0.2, 0.2), (0.15, 0.15), (0.02, 0.1)]
)
def test_a_robot_that_stopped_by_itself_waits_for_neutral(
    ttl_s: float | None, let_be_s: float
) -> None:
    """A tick may be as late as the robot's own timeout, but no less than 100 and at most 200 ms."""
    bench = Bench(limits=replace(FakeDriver.limits, ttl_s=ttl_s))
    bench.enter(A, B)
    bench.step()
    bench.drive()
    assert bench.step(0.02 + let_be_s - 0.001) == [("apply", AHEAD, 1)]
    bench.step(0.001)  # on the schedule again
    bench.offer(1.0)
    assert bench.step(0.02 + let_be_s + 0.001) == [("stop", 1), ("apply", STANDSTILL, 1)]
    assert not bench.moves()


# --- turns ------------------------------------------------------------------------------------


def test_robot_stops_at_every_change_of_operator(bench: Bench) -> None:
    """At the end of a turn the robot is stopped in both turns before anybody hears of it."""
    bench.drive()
    told = bench.step(60.0)
    assert told[:3] == [("stop", 1), ("stop", 1), ("stop", 2)]
    assert told[-1] == ("apply", STANDSTILL, 2)
    assert bench.calls_before_event[-1] == ("stop", 2)
    assert isinstance(bench.events[-2], TurnEnded)
    assert isinstance(bench.events[-1], TurnStarted)


def test_hand_over_without_lateness() -> None:
    """When a turn ends on time its operator stops driving, and the next one can."""
    bench = Bench(turn_s=10.0)
    bench.enter(A, B)
    bench.step()
    bench.drive()
    while bench.turns.operator == A:
        bench.offer(1.0)
        told = bench.step()
    assert told == [("stop", 1), ("stop", 2), ("apply", STANDSTILL, 2)]
    assert bench.offer(1.0, viewer=A) is Refusal.NOT_YOUR_TURN
    assert not bench.moves()
    bench.drive(viewer=B)


def test_leaving_stops_the_robot(bench: Bench) -> None:
    """When the operator leaves or is gone the robot stops at once, not at the next step."""
    bench.drive()
    bench.loop.leave(A)
    assert bench.driver.take() == [("stop", 1), ("stop", 2)]
    bench.drive(viewer=B)
    bench.loop.gone(B)
    assert bench.driver.take() == [("stop", 2)]
    assert bench.step() == [("apply", STANDSTILL, 2)]


def test_renewal_does_not_stop() -> None:
    """A lone operator's turn renews while the robot moves, and nothing stops it."""
    bench = Bench(turn_s=10.0)
    bench.enter(A)
    bench.step()
    bench.drive()
    while not isinstance(bench.events[-1], TurnRenewed):
        bench.offer(1.0)
        assert bench.step() == [("apply", AHEAD, 1)]


def test_others_may_come_and_go(bench: Bench) -> None:
    """Other viewers' joins and leaves neither stop the robot nor reach its driver."""
    bench.drive()
    bench.enter(3)
    bench.loop.lost(B)
    bench.loop.returned(B)
    bench.loop.leave(3)
    bench.loop.gone(3)
    assert bench.driver.take() == []
    assert bench.step() == [("apply", AHEAD, 1)]


def test_lost_place_is_told(bench: Bench) -> None:
    """The room is told when a lost viewer loses their place, and the robot drives on."""
    bench.drive()
    bench.loop.lost(B)
    while PlaceLost(B) not in bench.events:
        bench.offer(1.0)
        assert bench.step() == [("apply", AHEAD, 1)]


def test_lost_operator_stops_the_robot(bench: Bench) -> None:
    """The robot stops at once when its operator is lost; their commands do not count meanwhile."""
    bench.drive()
    bench.loop.lost(A)
    assert bench.driver.take() == [("stop", 1)]
    bench.loop.lost(A)
    assert bench.driver.take() == []
    assert bench.offer(1.0) is Refusal.LOST
    assert bench.step() == [("apply", STANDSTILL, 1)]
    assert bench.statuses[-1] == (A, False, Refusal.LOST.value)


def test_returned_operator_begins_with_neutral(bench: Bench) -> None:
    """After a short loss the same turn goes on, but only after a new deliberate command."""
    bench.drive()
    bench.loop.lost(A)
    bench.step(1.0)
    bench.loop.returned(A)
    assert not bench.moves()
    bench.drive()


@pytest.mark.parametrize("again", ["connect", "returned"])
def test_fresh_page_counts_from_the_start(bench: Bench, again: str) -> None:
    """A reloaded page of the operator's begins its sequence anew, with a stopped robot."""
    bench.drive()
    getattr(bench.loop, again)(A)
    assert bench.driver.take() == [("stop", 1)]
    bench.seq = 0
    assert not bench.moves()
    bench.drive()


@pytest.mark.parametrize("again", ["connect", "returned"])
def test_fresh_page_is_told_how_things_are(bench: Bench, again: str) -> None:
    """A viewer who has just connected gets the full status, even if nothing has changed."""
    getattr(bench.loop, again)(A)
    bench.step()
    told = len(bench.statuses)
    getattr(bench.loop, again)(A)
    bench.step()
    assert bench.statuses[told:] == [bench.statuses[told - 1]]


# --- stop -------------------------------------------------------------------------------------


def test_stop_reaches_the_robot_at_once(bench: Bench) -> None:
    """A stop by anybody reaches the robot within the call, and lasts."""
    bench.drive()
    assert bench.loop.press_stop(says("Bob")) == 1
    assert bench.driver.take() == [("stop", 1)]
    assert bench.loop.latched == LatchedStop(1, says("Bob"))
    for linear in (0.0, 1.0, 0.0, 1.0):
        bench.offer(linear)
        assert bench.step() == [("apply", STANDSTILL, 1)]
    assert bench.statuses[-1] == (A, False, stopped_by(says("Bob")))


@pytest.mark.parametrize("what", ["a stop of somebody else", "the robot", "the camera", "the host"])
def test_the_turns_clock_stands_still(bench: Bench, what: str) -> None:
    """The turn's clock pauses while the robot, its camera or another's stop prevents driving."""
    bench.drive()
    ends_s = bench.turns.ends_s
    if what == "the robot":
        bench.loop.lend_driver(says("away"))
    elif what == "the camera":
        bench.view.camera = SimpleNamespace(problem=says("unplugged"))
    elif what == "the host":
        bench.operators.on_hold = says("held")
    else:
        bench.loop.press_stop(says("Bob"), viewer=B)
    for _ in range(2):
        bench.step()
    assert bench.turns.paused_left_s(bench.clock.now_s()) is not None
    assert bench.turns.ends_s == pytest.approx((ends_s or 0.0) + 60.0, abs=0.1)


@pytest.mark.parametrize("by", [A, B])
def test_the_next_turns_clock_stands_still_from_its_beginning(by: int) -> None:
    """Whether the Stop is the operator's own is decided again for each turn."""
    bench = Bench(turn_s=5.0)
    bench.enter(A, B)
    bench.loop.press_stop(says("somebody"), viewer=by)
    while bench.turns.operator == A:
        bench.step(5.0)
    assert (bench.turns.paused_left_s(bench.clock.now_s()) is None) is (by == B)


def test_no_clock_stands_still_for_their_own_stop_or_link(bench: Bench) -> None:
    """Neither the operator's own Stop nor their lost connection prolongs the turn."""
    bench.drive()
    bench.loop.press_stop(says("Ada"), viewer=A)
    bench.step()
    bench.step()
    assert bench.turns.paused_left_s(bench.clock.now_s()) is None
    bench.view.camera = SimpleNamespace(problem=says("unplugged"))
    bench.loop.lost(A)
    bench.step()
    bench.step()
    assert bench.turns.paused_left_s(bench.clock.now_s()) is None


def test_the_host_slows_the_robot(bench: Bench) -> None:
    """A limit of the host's takes effect with the next tick, and the operator is told."""
    bench.drive()
    bench.operators.fraction = 0.25
    bench.offer(1.0)
    bench.step()
    slow = Twist(AHEAD.linear_mps / 4, AHEAD.angular_rps / 4)
    assert ("apply", slow, bench.turns.number) in bench.step()
    assert bench.statuses[-1][2] == Limit.BY_HOST.value


def test_pressing_again_stops_again(bench: Bench) -> None:
    """A second press stops the robot again; the stop keeps its number and name."""
    assert bench.loop.press_stop(says("Bob")) == 1
    assert bench.loop.press_stop(says("Eve")) == 1
    assert bench.driver.take()[-2:] == [("stop", 1), ("stop", 1)]
    assert bench.loop.latched == LatchedStop(1, says("Bob"))


@pytest.mark.parametrize("releaser", [A, "host"])
def test_release_moves_nothing(bench: Bench, releaser: Releaser) -> None:
    """After a release by the operator or the host, driving resumes from neutral."""
    bench.drive()
    number = bench.loop.press_stop(says("Bob"))
    bench.step()
    assert bench.loop.release_stop(releaser, number, bench.clock.time_s) is None
    assert bench.loop.latched is None
    assert bench.driver.take() == [("stop", 1)]
    assert not bench.moves()
    assert bench.statuses[-1] == (A, False, Hold.STOPPED.value)
    bench.drive()


def test_release_without_a_beat_between_moves_nothing(bench: Bench) -> None:
    """Even if stop and release come within one tick, neutral must come first."""
    bench.drive()
    bench.loop.release_stop(A, bench.loop.press_stop(says("Bob")), None)
    assert not bench.moves()


def test_stops_are_counted(bench: Bench) -> None:
    """Presses are counted, and releases by their outcome."""
    bench.loop.press_stop(says("Bob"))
    number = bench.loop.press_stop(says("Eve"))
    bench.loop.release_stop(B, number, None)
    bench.loop.release_stop(A, number, None)
    bench.loop.release_stop(A, number, None)
    counts = bench.loop.counts()
    assert {name: n for name, n in counts.items() if name.startswith("stops.")} == {
        "stops.pressed": 2,
        "stops.refused.not_your_stop": 1,
        "stops.refused.other_stop": 1,
        "stops.released": 1,
    }


def test_others_do_not_release(bench: Bench) -> None:
    """A waiting viewer cannot release the stop, and refusals are counted by reason."""
    number = bench.loop.press_stop(says("Ada"))
    assert bench.loop.release_stop(B, number, bench.clock.time_s) is Refusal.NOT_YOUR_STOP
    assert bench.loop.latched is not None
    assert bench.loop.counts()["stops.refused.not_your_stop"] == 1


def test_stop_lives_across_turns(bench: Bench) -> None:
    """The next operator finds the stop latched, and only they may release it then."""
    bench.drive()
    number = bench.loop.press_stop(says("Ada"))
    bench.loop.leave(A)
    bench.offer(viewer=B)
    bench.offer(1.0, viewer=B)
    assert bench.step() == [("apply", STANDSTILL, 2)]
    assert bench.statuses[-1] == (B, False, stopped_by(says("Ada")))
    assert bench.loop.release_stop(A, number, bench.clock.time_s) is Refusal.NOT_YOUR_STOP
    assert bench.loop.release_stop(B, number, bench.clock.time_s) is None
    bench.drive(viewer=B)


def test_stop_goes_out_although_nothing_can_be_noted() -> None:
    """The robot is stopped before anything else that could fail, such as the clock."""
    bench = Bench()
    bench.clock.now_s = lambda: 1 / 0  # type: ignore[method-assign]
    with pytest.raises(ZeroDivisionError):
        bench.loop.press_stop(says("Bob"))
    assert bench.driver.take() == [("stop", 0)]


def test_stop_latches_although_the_driver_fails_badly(bench: Bench) -> None:
    """Even an exception that the safe driver lets through does not prevent the latch."""

    def interrupted(turn: int) -> None:
        raise KeyboardInterrupt

    bench.driver.stop = interrupted  # type: ignore[method-assign]
    with pytest.raises(KeyboardInterrupt):
        bench.loop.press_stop(says("Bob"))
    assert bench.loop.latched == LatchedStop(1, says("Bob"))


def test_after_stop_nothing_moves(bench: Bench) -> None:
    """Once the loop is stopped nothing moves the robot, and stopping twice is safe."""
    bench.drive()
    bench.loop.stop()
    bench.loop.stop()
    assert bench.driver.take() == [("stop", 1), ("stop", 1)]
    bench.offer(-1.0)
    assert bench.step() == []
    bench.clock.time_s += 60.0
    bench.loop.tick_turns()
    assert bench.turns.operator == A, "a turn began that nobody can drive"


# --- the robot --------------------------------------------------------------------------------


def test_an_axis_goes_out_at_once(bench: Bench) -> None:
    """A camera turns as soon as its command arrives, even while the robot stands still."""
    bench.offer()
    bench.step()
    bench.clock.time_s += 0.006
    bench.pan(0.5)
    assert ("set_axis", "pan", 0.5, 1) in bench.driver.take()
    assert bench.statuses[-1] == (A, False, None)


def test_axes_move_on_change(bench: Bench) -> None:
    """An axis is set when its position changes, and again after the robot has reconnected.

    It moves only while the dead-man is held.
    """
    bench.offer()
    bench.pan(0.5)
    assert ("set_axis", "pan", 0.5, 1) in bench.step()
    bench.pan(0.5)
    assert bench.step() == [("apply", STANDSTILL, 1)]
    bench.driver.now = RobotState(connected=True, epoch=2)
    bench.step()
    bench.pan(0.5, held=False)
    assert bench.step() == [("apply", STANDSTILL, 1)]
    bench.pan(0.5)
    assert ("set_axis", "pan", 0.5, 1) in bench.step()


def test_who_begins_knows_where_the_axes_are(bench: Bench) -> None:
    """A new operator learns the axes' last positions, none if unknown after a reconnection."""
    assert bench.loop.first_axes == {}
    bench.offer()
    bench.pan(0.5)
    bench.step()
    assert bench.loop.first_axes == {}
    bench.loop.leave(A)
    bench.step()
    assert bench.turns.operator == B
    assert bench.loop.first_axes == {"pan": 0.5}
    bench.driver.now = RobotState(connected=True, epoch=2)
    bench.step()
    bench.loop.join(A)
    bench.loop.leave(B)
    bench.step()
    assert bench.loop.first_axes == {}


def test_who_is_called_answers_and_drives() -> None:
    """The loop passes on a viewer's answer to a call, and the host's decisions on the queue."""
    bench = Bench(ready_s=10.0)
    bench.loop.hold_queue(True)
    bench.enter(A, B)
    assert bench.turns.operator is None
    bench.loop.hold_queue(False)
    assert bench.turns.operator == A
    bench.step(50.0)
    call = bench.turns.call
    assert call is not None
    assert call.viewer == B
    bench.loop.answer_call(B)
    assert bench.turns.call is None
    bench.step(10.0)
    assert bench.turns.operator == B


@pytest.mark.parametrize("hold", ["stop", "fault"])
def test_a_slider_moved_during_a_hold_moves_nothing_after(bench: Bench, hold: str) -> None:
    """While nothing may move no axis does, and a position asked for then is never applied."""
    bench.offer()
    bench.step()
    if hold == "stop":
        number = bench.loop.press_stop(says("Bob"))
        bench.pan(0.5)
        assert bench.step() == [("apply", STANDSTILL, 1)]
        bench.loop.release_stop(A, number, None)
    else:
        bench.driver.now = RobotState(connected=True, epoch=2)
    bench.step()
    bench.pan(0.5)
    assert bench.step() == [("apply", STANDSTILL, 1)]
    bench.pan(0.5, held=False)
    assert bench.step() == [("apply", STANDSTILL, 1)]
    bench.offer(1.0)
    assert bench.step() == [("apply", AHEAD, 1)]
    bench.pan(0.4)
    assert ("set_axis", "pan", 0.4, 1) in bench.step()


def test_new_connection_of_the_robot_needs_neutral(bench: Bench) -> None:
    """A robot that has reconnected stands until a new deliberate command."""
    bench.drive()
    bench.driver.now = RobotState(connected=True, epoch=2)
    assert bench.step() == [("stop", 1), ("apply", STANDSTILL, 1)]
    assert bench.statuses[-1] == (A, False, Hold.FAULT.value)
    assert not bench.moves()
    bench.driver.now = RobotState(connected=True, epoch=3)
    assert bench.step() == [("stop", 1), ("apply", STANDSTILL, 1)]
    bench.drive()


@pytest.mark.parametrize(
    ("state", "reason"),
    [
        (RobotState(connected=False, epoch=1), NOT_CONNECTED),
        (
            RobotState(connected=True, epoch=1, problem="The battery is empty."),
            says("The battery is empty."),
        ),
    ],
)
def test_robot_with_a_problem_stands(bench: Bench, state: RobotState, reason: Sentence) -> None:
    """A robot with a problem stands, the operator is told, and then neutral must come first."""
    bench.drive()
    healthy, bench.driver.now = bench.driver.now, state
    assert bench.step() == [("stop", 1), ("apply", STANDSTILL, 1)]
    assert bench.statuses[-1] == (A, False, reason)
    assert not bench.moves()
    bench.driver.now = healthy
    assert not bench.moves()
    bench.drive()


@pytest.mark.parametrize("broken", ["state", "apply", "set_axis"])
def test_driver_that_raises_is_stopped(bench: Bench, broken: str) -> None:
    """A driver that raises is stopped, logged once and reported, and the loop keeps running."""
    bench.drive()
    bench.driver.broken = {broken}
    pan = iter((0.1, 0.2, 0.3, 0.4))
    with capture_logs() as logs:
        for _ in range(2):
            bench.offer()
            bench.loop.handle_command(A, replace(bench.command(1.0), axes={"pan": next(pan)}))
            assert ("stop", 1) in bench.step()
            assert bench.statuses[-1] == (A, False, NO_ANSWER)
    assert [entry["log_level"] for entry in logs] == ["error"]
    assert bench.loop.counts()["control.driver_failures"] == 2
    bench.driver.broken = set()
    assert not bench.moves()
    bench.drive()


@pytest.mark.parametrize("bad", ["raises", "returns nothing"])
def test_last_state_is_kept_while_the_driver_fails(bench: Bench, bad: str) -> None:
    """While the driver does not answer, its last state is shown with that problem."""
    known = RobotState(connected=True, epoch=1, battery_fraction=0.7)
    bench.driver.now = known
    bench.step()
    assert bench.loop.robot_state == known
    if bad == "raises":
        bench.driver.broken = {"state"}
    else:
        bench.driver.now = None  # type: ignore[assignment]  # somebody's driver is not checked
    with capture_logs():
        bench.step()
        assert bench.loop.robot_state == replace(known, problem=NO_ANSWER)
        assert not bench.moves()
    bench.driver.broken, bench.driver.now = set(), known
    bench.step()
    assert bench.loop.robot_state == known


def test_nothing_is_known_before_the_first_beat() -> None:
    """Before the first tick the robot counts as not connected."""
    assert Bench().loop.robot_state == RobotState(connected=False)


def test_driver_that_cannot_even_stop(bench: Bench) -> None:
    """An exception from a stop is contained, and standstill follows at the next tick."""
    bench.drive()
    bench.driver.broken = {"stop"}
    with capture_logs() as logs:
        assert bench.loop.press_stop(says("Ada")) == 1
    assert len(logs) == 1
    assert bench.step() == [("apply", STANDSTILL, 1)]


# --- maintenance ------------------------------------------------------------------------------


def test_lent_driver_hears_nothing(bench: Bench) -> None:
    """A driver that is lent gets one stop and then no more calls from the loop."""
    bench.drive()
    bench.loop.lend_driver(says("The stop is being proved."))
    assert bench.driver.take() == [("stop", 1)]
    bench.loop.lend_driver(says("The stop is being proved, still."))
    bench.driver.broken = {"state", "apply", "stop"}  # as when its cable is unplugged
    for _ in range(10):
        bench.offer(0.0)
        bench.offer(1.0)
        assert bench.step() == []
    bench.loop.leave(A)
    assert bench.step() == []
    assert bench.statuses[-2] == (A, False, says("The stop is being proved, still."))
    assert bench.loop.robot_state.problem == says("The stop is being proved, still.")
    assert bench.loop.robot_state.moving is None
    assert bench.loop.counts()["control.driver_failures"] == 0


def test_stop_is_heard_even_by_a_lent_driver(bench: Bench) -> None:
    """A pressed stop and the end of the loop reach even a lent driver."""
    bench.loop.lend_driver(says("The stop is being proved."))
    bench.driver.take()
    bench.loop.press_stop(says("Bob"))
    assert bench.driver.take() == [("stop", 1)]
    bench.loop.stop()
    assert bench.driver.take() == [("stop", 1)]


def test_driver_that_comes_back_begins_with_neutral(bench: Bench) -> None:
    """After maintenance the robot is stopped, its axes are unknown, and neutral must come first."""
    bench.offer()
    bench.pan(0.5)
    bench.step()
    bench.loop.lend_driver(says("The stop is being proved."))
    bench.step()
    bench.loop.lend_driver(None)
    assert bench.step() == [("stop", 1), ("apply", STANDSTILL, 1)]
    assert bench.statuses[-1] == (A, False, Hold.FAULT.value)
    assert not bench.moves()
    bench.offer()
    bench.pan(0.5)
    assert ("set_axis", "pan", 0.5, 1) in bench.step()


def test_taking_back_what_was_not_lent_is_nothing(bench: Bench) -> None:
    """Taking back a driver that was not lent does not stop the robot."""
    bench.drive()
    bench.loop.lend_driver(None)
    assert bench.step() == [("apply", AHEAD, 1)]


def test_what_the_robot_says_of_itself_is_passed_on(bench: Bench) -> None:
    """Whether the robot moves is reported as it says, and as unknown while it does not answer."""
    bench.driver.now = RobotState(connected=True, epoch=1, moving=True)
    bench.step()
    assert bench.loop.robot_state.moving is True
    bench.driver.broken = {"state"}
    with capture_logs():
        bench.step()
    assert bench.loop.robot_state.moving is None


# --- ramp, sight and reach --------------------------------------------------------------------


def test_speed_grows_beat_by_beat() -> None:
    """From tick to tick the speed grows by the acceleration times the elapsed time."""
    bench = Bench(robot=RobotSettings(max_linear_acceleration_mps2=1.0))
    bench.enter(A)
    bench.step()
    bench.offer()
    bench.step()
    bench.offer(1.0)
    speeds = [bench.step(after_s)[-1][1] for after_s in (0.02, 0.01, 0.04, 0.1)]
    assert [round(twist.linear_mps, 6) for twist in speeds] == [0.02, 0.03, 0.07, 0.11]  # type: ignore[attr-defined]
    bench.offer()
    assert bench.step()[-1] == ("apply", STANDSTILL, 1)


def test_soft_body_is_braked_and_then_stopped() -> None:
    """With soft braking, silence brakes at the configured rate, and Stop still stops at once."""
    bench = Bench(robot=AGILE.model_copy(update={"soft_braking": True, "braking_mps2": 10.0}))
    bench.enter(A)
    bench.step()
    bench.drive()
    for _ in range(11):
        bench.step()
    told = [call for _ in range(3) for call in bench.step()]
    speeds = [call[1].linear_mps for call in told if call[0] == "apply"]  # type: ignore[attr-defined]
    assert [round(speed, 6) for speed in speeds] == [0.3, 0.1, 0.0]
    assert told[-2:] == [("stop", 1), ("apply", STANDSTILL, 1)]
    bench.drive()
    bench.loop.press_stop(says("Bob"))
    assert bench.step() == [("apply", STANDSTILL, 1)]


def test_who_sees_late_is_slowed_and_told_why(bench: Bench) -> None:
    """A late picture slows the robot, with a reason for the operator; a too late one stops it."""
    bench.drive()
    late = replace(bench.command(1.0), seen_s=bench.clock.time_s - 0.52)
    bench.loop.handle_command(A, late)
    assert ("apply", Twist(0.25, 0.0), 1) in bench.step()
    assert bench.statuses[-1] == (A, True, Limit.LATE_PICTURE.value)
    assert bench.shares[-1] == 0.5
    blind = replace(bench.command(1.0), seen_s=bench.clock.time_s - 0.92)
    bench.loop.handle_command(A, blind)
    assert ("stop", 1) in bench.step()
    assert bench.statuses[-1] == (A, False, Refusal.BLIND.value)
    assert bench.shares[-1] == 0.0


def test_who_does_not_want_to_see_drives_slowly(bench: Bench) -> None:
    """With the picture switched off on purpose, the robot is limited to slow speed."""
    bench.operators.has_picture = False
    bench.offer()
    bench.step()
    bench.loop.handle_command(A, replace(bench.command(1.0), seen_s=None))
    assert bench.step() == [("apply", Twist(0.25, 0.0), 1)]
    assert bench.statuses[-1] == (A, True, Limit.NO_PICTURE.value)


def with_bumpers(bumpers: int) -> RobotState:
    """Make the state of a connected robot that reports these bumper bits."""
    return RobotState(connected=True, epoch=1, bumpers=bumpers)


def test_who_drives_against_a_pressed_bumper_reads_so(bench: Bench) -> None:
    """While a bumper is pressed, an operator who asks for motion is told so."""
    bench.drive()
    bench.driver.now = with_bumpers(2)
    for linear in (1.0, 0.0, -1.0):
        bench.offer(linear)
        assert bench.step() == [("apply", Twist(0.5 * linear, 0.0), 1)]
    bench.driver.now = with_bumpers(0)
    bench.step()
    assert bench.statuses[-5:] == [
        (A, True, None),
        (A, True, Limit.BUMPER.value),
        (A, False, None),
        (A, True, Limit.BUMPER.value),
        (A, True, None),
    ]


def test_a_bumper_is_the_last_thing_to_be_told(bench: Bench) -> None:
    """Any other reason for a slow or standing robot is shown instead of a pressed bumper."""
    bench.driver.now = with_bumpers(1)
    bench.offer(1.0)
    bench.step()
    assert bench.statuses[-1] == (A, False, Hold.FAULT.value)
    bench.operators.has_picture = False
    bench.offer()
    bench.step()
    bench.offer(1.0)
    bench.step()
    assert bench.statuses[-1] == (A, True, Limit.NO_PICTURE.value)


def test_a_long_line_is_a_slow_one() -> None:
    """Over a link with a longer delay the same robot is limited more, with a reason."""
    robot = RobotSettings(max_linear_acceleration_mps2=100.0, braking_mps2=2.0)
    speeds = []
    for delay_s in (0.0, 0.3):
        bench = Bench(robot=robot, max_stop_distance_m=0.25)
        bench.operators.delays_s[A] = delay_s
        bench.enter(A)
        bench.step()
        bench.offer()
        bench.offer(1.0)
        [(_, twist, _)] = [call for call in bench.step() if call[0] == "apply"]
        assert isinstance(twist, Twist)
        speeds.append(twist.linear_mps)
        reason = Limit.LONG_DELAY.value if delay_s else None
        assert bench.statuses[-1] == (A, True, reason)
    assert speeds[1] < speeds[0] == 0.5


def test_a_line_that_is_too_long_is_for_watching() -> None:
    """Over a link on which every command would be too old nobody can drive, and is told why."""
    bench = Bench()
    bench.operators.delays_s[A] = 0.351
    bench.enter(A)
    bench.step()
    assert bench.offer() is Refusal.TOO_SLOW
    assert bench.offer(1.0) is Refusal.TOO_SLOW
    assert bench.step() == [("apply", STANDSTILL, 1)]
    assert bench.statuses[-1] == (A, False, Refusal.TOO_SLOW.value)


def test_a_line_that_gets_faster_is_driven_over_in_the_same_turn() -> None:
    """If only the first answer was late, an operator who presses again can drive."""
    bench = Bench()
    bench.operators.delays_s[A] = 0.351
    bench.enter(A)
    bench.step()
    assert bench.offer(1.0) is Refusal.TOO_SLOW
    bench.operators.delays_s[A] = 0.1
    bench.step()
    bench.drive()
    assert bench.statuses[-1] == (A, True, None)


@pytest.mark.parametrize(("lapse_s", "goes_on"), [(0.9, True), (1.1, False)])
def test_driving_goes_on_after_a_short_lapse(bench: Bench, lapse_s: float, goes_on: bool) -> None:
    """After a lapse of up to a second driving resumes; after a longer one neutral must come first.

    Either lapse is counted once.
    """
    bench.drive()
    assert "commands.lapsed" not in bench.loop.counts()
    lapse_s += 0.25  # the last command was fresh for this long
    for _ in range(round(lapse_s / 0.02)):
        bench.step()
    assert bench.moves() is goes_on
    assert bench.loop.counts().get("control.late") is None
    assert bench.loop.counts()["commands.lapsed"] == 1


# --- the link ---------------------------------------------------------------------------------


def test_delay_is_taken_at_the_turns_start(bench: Bench) -> None:
    """A link that gets slower within the turn gets no further allowance."""
    bench.drive()
    bench.operators.delays_s[A] = 0.9
    old = replace(bench.command(1.0), sent_s=bench.clock.time_s - 0.26)
    assert bench.loop.handle_command(A, old) is Refusal.TOO_OLD


def test_delay_is_taken_as_soon_as_known() -> None:
    """A delay not yet measured when the turn starts counts as none until it is."""
    bench = Bench()
    del bench.operators.delays_s[A]
    bench.enter(A)
    bench.step()
    old = replace(bench.command(), sent_s=bench.clock.time_s - 0.2)
    assert bench.loop.handle_command(A, old) is Refusal.TOO_OLD
    bench.operators.delays_s[A] = 0.1
    old = replace(bench.command(), sent_s=bench.clock.time_s - 0.2)
    bench.clock.time_s += 0.02
    assert bench.loop.handle_command(A, old) is None


@pytest.mark.parametrize(("delay_s", "refusal"), [(0.3, None), (None, Refusal.TOO_OLD)])
def test_delay_is_taken_anew_when_the_turn_renews(
    delay_s: float | None, refusal: Refusal | None
) -> None:
    """A renewed turn uses a new measurement of the delay, or the old one if there is none."""
    bench = Bench()
    bench.enter(A)
    bench.step()
    del bench.operators.delays_s[A]
    if delay_s is not None:
        bench.operators.delays_s[A] = delay_s
    bench.step(60.0)
    old = replace(bench.command(), sent_s=bench.clock.time_s - 0.4)
    assert bench.loop.handle_command(A, old) is refusal
    old = replace(bench.command(), sent_s=bench.clock.time_s - 0.2)
    assert bench.loop.handle_command(A, old) is None


def test_delay_is_not_the_last_operators(bench: Bench) -> None:
    """A new operator whose link is not measured yet gets no allowance from the last one's."""
    bench.drive()
    del bench.operators.delays_s[B]
    bench.loop.leave(A)
    old = replace(bench.command(), sent_s=bench.clock.time_s - 0.2)
    assert bench.loop.handle_command(B, old) is Refusal.TOO_OLD


def test_lateness_is_told_to_a_tenth(bench: Bench) -> None:
    """Lateness is reported in milliseconds, rounded to one decimal."""
    bench.step(0.02 + 0.01234)
    counts = bench.loop.counts()
    assert counts["control.latest_ms"] == counts["control.jitter_p99_ms"] == 12.3


def test_commands_are_counted(bench: Bench) -> None:
    """Commands are counted as accepted or by why they were refused."""
    bench.drive()
    bench.offer(viewer=B)
    assert bench.loop.counts() == {
        "commands.accepted": 2,
        "commands.refused.not_your_turn": 1,
        "control.driver_failures": 0,
        "control.jitter_p99_ms": 0.0,
        "control.latest_ms": 0.0,
    }


# --- running ----------------------------------------------------------------------------------


async def heard(driver: FakeDriver, *call: object) -> None:
    """Wait until the driver gets this call."""
    async with asyncio.timeout(5):
        while call not in driver.calls:
            driver.called.clear()
            await driver.called.wait()


def page(seq: int, linear: float) -> Command:
    """Make the command that a page would send now."""
    now_s = SystemClock().now_s()
    return Command(seq, 1, now_s, linear, 0.0, linear != 0, "fast", seen_s=now_s, heard_s=now_s)


def live(
    driver: FakeDriver,
    *,
    loop_hz: float = 100.0,
    max_age_ms: float = 1000.0,
    one_way_s: float = 1.0,
    listener: Listener | None = None,
) -> ControlLoop:
    """Make a loop on the real clock."""
    slow = DriveSettings(max_age_ms=max_age_ms, max_command_age_ms=2000.0, max_stop_distance_m=10.0)
    return make_loop(
        SystemClock(),
        driver,
        *([listener] if listener else []),
        operators=FakeOperators(one_way_s),
        drive=slow.model_copy(update={"loop_hz": loop_hz}),
    )


def test_a_listener_hears_of_all_once_the_robot_has_it() -> None:
    """The listener gets each command's outcome and each set-point, after the robot has it."""
    bench = Bench()
    bench.enter(A, B)
    bench.step()
    bench.drive()
    heard = bench.listened
    assert ("offered", A, 2, None) in heard
    assert ("steered", AHEAD, AHEAD, 1) in heard
    assert ("apply", AHEAD, 1) in bench.calls_before_steered
    heard.clear()
    bench.offer(1.0, viewer=B)
    assert heard == [("offered", B, 3, Refusal.NOT_YOUR_TURN)]


@asynccontextmanager
async def running(control: ControlLoop) -> AsyncIterator[asyncio.Task[None]]:
    """Run it, and cancel it after the block."""
    task = asyncio.create_task(control.run())
    try:
        yield task
    finally:
        task.cancel()
        with suppress(asyncio.CancelledError):
            await task


async def test_runs_until_cancelled_and_stops_the_robot() -> None:
    """While running, the loop ticks by itself and moves the robot; it ends with a stop."""
    driver = FakeDriver()
    control = live(driver)
    async with running(control):
        control.connect(A)
        control.join(A)
        for seq in itertools.count():  # as a page does: a busy machine may require neutral again
            if ("apply", AHEAD, 1) in driver.calls:
                break
            control.handle_command(A, page(seq, seq % 2))
            driver.called.clear()
            await driver.called.wait()
    assert driver.calls[-1] == ("stop", 1)
    await asyncio.sleep(0.05)  # so that the pending timer fires after the end


async def test_hurried_change_does_not_wait_for_the_beat() -> None:
    """A change that comes too soon is sent as soon as the minimum gap allows, and only once."""
    driver = FakeDriver()
    control = live(driver, loop_hz=0.1)  # so slow that no further tick comes in this test
    control.connect(A)
    control.join(A)
    async with running(control) as task:
        await heard(driver, "apply", STANDSTILL, 1)
        control.handle_command(A, page(1, 0.0))
        control.handle_command(A, page(2, 1.0))
        await heard(driver, "apply", AHEAD, 1)
        await asyncio.wait([task], timeout=0.03)
        assert len(driver.applied_s) == 2


async def test_the_end_of_a_command_does_not_wait_for_the_beat() -> None:
    """The robot is stopped when the command expires, without waiting for the next tick."""
    driver = FakeDriver()
    control = live(driver, loop_hz=0.1, max_age_ms=200.0, one_way_s=0.001)
    control.connect(A)
    control.join(A)
    control.step(SystemClock().now_s())
    control.handle_command(A, page(1, 0.0))
    async with running(control):
        await asyncio.sleep(0.01)
        control.handle_command(A, page(2, 1.0))
        await heard(driver, "apply", AHEAD, 1)
        driver.calls.clear()
        await heard(driver, "stop", 1)


async def test_waiting_for_the_gap_is_no_work() -> None:
    """A change that comes too soon waits without using the event loop."""

    class Watched(TurnedClock):
        looks = 0

        def now_s(self) -> float:
            self.looks += 1
            return super().now_s()

    watched = Watched()
    bench = Bench(clock=watched)
    bench.enter(A)
    bench.step()
    bench.offer()
    bench.offer(1.0)  # too soon, as the clock stands
    async with running(bench.loop):
        watched.looks = 0
        for _ in range(1000):
            await asyncio.sleep(0)
        assert watched.looks < 1000
        assert bench.driver.take() == []
        watched.time_s += 0.006
        await heard(bench.driver, "apply", AHEAD, 1)


async def test_flood_keeps_the_gap() -> None:
    """However fast changes come, set-points are at least 5 ms apart."""
    driver = FakeDriver()
    control = live(driver)
    control.connect(A)
    control.join(A)
    control.step(SystemClock().now_s())
    async with running(control):
        seq = 0
        while len(driver.applied_s) < 12:
            seq += 1
            control.handle_command(A, page(seq, seq % 3 / 2))
            await asyncio.sleep(0)
    gaps_s = [b - a for a, b in itertools.pairwise(driver.applied_s)]
    assert min(gaps_s) > 0.0045


async def test_stopped_loop_stays_quiet() -> None:
    """After `stop` a running loop sends nothing more to the robot, and waits to be cancelled."""
    driver = FakeDriver()
    control = live(driver)
    async with running(control) as task:
        await heard(driver, "apply", STANDSTILL, 0)
        control.stop()
        calls = len(driver.calls)
        done, _ = await asyncio.wait([task], timeout=0.03)
        assert not done
        assert len(driver.calls) == calls


async def test_defect_stops_the_robot() -> None:
    """A listener that raises ends the loop, which its supervisor sees, and stops the robot."""

    class Defect(Listener):
        def drive_status(self, *_: object) -> None:
            raise RuntimeError("defect")

    driver = FakeDriver()
    control = live(driver, listener=Defect())
    control.connect(A)
    control.join(A)
    with pytest.raises(RuntimeError, match="defect"):
        await control.run()
    assert driver.calls[-1] == ("stop", 1)
