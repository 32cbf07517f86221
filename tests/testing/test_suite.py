"""The driver suite passes a correct driver, and catches a wrong one for each promise."""

from __future__ import annotations

import subprocess
import sys
import threading
from typing import TYPE_CHECKING, Final

import pytest
from tests.testing import robots
from tests.testing.robots import InMemory, Right, Robot

from wax.clock import SystemClock
from wax.testing import DriverSafety

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.driver.interface import Driver

pytestmark = pytest.mark.system

WRONG: Final[tuple[tuple[type[Right], str, str], ...]] = (
    (robots.MovesWhenOpened, "it_moves_when_told_and_stops_when_told", "opened, it was told"),
    (robots.GoesTheWrongWay, "it_moves_when_told_and_stops_when_told", "the wrong way"),
    (robots.NeverMovesSideways, "it_moves_when_told_and_stops_when_told", "did not move the robot"),
    (robots.GoesRightForLeft, "it_moves_when_told_and_stops_when_told", "the wrong way"),
    (robots.KnowsNoLimitsYet, "it_says_what_it_is_before_it_is_opened", "has changed them"),
    (robots.HasNoEndOfItsSpeed, "it_says_what_it_is_before_it_is_opened", "must be finite"),
    (robots.HasNoEndSideways, "it_says_what_it_is_before_it_is_opened", "must be finite"),
    (robots.ConnectsWhenBuilt, "building_it_touches_nothing", "constructor has left"),
    (robots.DisturbsTheOther, "building_it_touches_nothing", "has disconnected this one"),
    (robots.RaisesWhenClosed, "nothing_raises_at_any_time", "the port is closed"),
    (robots.RaisesForAnUnknownAxis, "nothing_raises_at_any_time", "no such axis"),
    (robots.RefusesAnOldStop, "stop_is_never_refused", "a stop of an old turn was not told within"),
    (robots.StopsLate, "stop_is_never_refused", "was not told within"),
    (robots.StopsBySilence, "stop_is_never_refused", "did not stop the robot at all"),
    (robots.DriftsOnAfterAStop, "stop_is_never_refused", "did not stop the robot at all"),
    (robots.SaysAStopOnce, "a_stop_is_told_again", "told 1 times"),
    (robots.FollowsAnOldTurn, "a_lower_turn_is_ignored", "of an old turn moved"),
    (robots.FollowsAnOldTurnSideways, "a_lower_turn_is_ignored", "of an old turn moved"),
    (robots.IsKeptGoingByAnOldTurn, "a_lower_turn_is_ignored", "kept the robot moving"),
    (robots.HasNoWatchdog, "silence_stops_it", "not told to stand"),
    (robots.StopsBySilence, "silence_stops_it", "not told to stand"),
    (robots.DriftsOnInSilence, "silence_stops_it", "not told to stand"),
    (robots.MovesByWhatIsNoNumber, "what_is_no_number_stops_it", "moved the robot"),
    (robots.IsKeptGoingByNoNumber, "what_is_no_number_stops_it", "kept the robot moving"),
    (robots.DriftsOnByNoNumber, "what_is_no_number_stops_it", "kept the robot moving"),
    (robots.HasNoLimits, "it_keeps_its_limits", "1000"),
    (robots.MovesSidewaysUnasked, "it_keeps_its_limits", "asked sideways, it was told to move"),
    (robots.IsFasterOnTheDiagonal, "it_keeps_its_limits", "a faster diagonal"),
    (robots.BlocksWhileItWrites, "every_call_returns_at_once", "apply takes"),
    (robots.BlocksWhileItOpens, "every_call_returns_at_once", "open.. waits"),
    (robots.HangsWhenAsked, "every_call_returns_at_once", "has not returned"),
    (robots.NeverEndsClosing, "closing_is_bounded_and_stops_first", "close.. took 1"),
    (robots.ClosesWithoutAStop, "closing_is_bounded_and_stops_first", "did not tell"),
    (robots.StaysConnected, "closing_is_bounded_and_stops_first", "connected after close"),
    (robots.OpensAgainByItself, "after_closing_nothing_moves", "opened it again|moved it"),
    (robots.GoesOnWhereItWas, "a_new_connection_begins_at_standstill", "of before moved"),
    (robots.CountsNoConnections, "a_new_connection_begins_at_standstill", "epoch must rise"),
    (robots.GoesOnWhereItWas, "a_mended_link_begins_at_standstill", "of before moved"),
    (robots.CountsNoConnections, "a_mended_link_begins_at_standstill", "epoch must rise"),
    (robots.DoesNotNoticeTheCut, "a_mended_link_begins_at_standstill", "does not notice"),
    (robots.WaitsForTheRobot, "a_robot_that_is_not_there_holds_nobody_up", "has not returned"),
    (robots.SaysNoProblem, "a_robot_that_is_not_there_holds_nobody_up", "no problem to say"),
    (robots.ForgetsWhoseTurnItIs, "anybody_may_stop_it", "moved on after a stop"),
    (robots.HasNoStateForAnother, "the_state_can_be_asked_by_anybody", "changed size"),
    (robots.SaysWhatCannotBeSent, "the_state_can_be_asked_by_anybody", "serialize"),
)


class Suite(InMemory):
    @pytest.fixture(autouse=True)
    def _robot(self) -> None:
        self.begin()

    def begin(self) -> None:
        self.robot = Robot()

    def make_driver(self, clock: Clock) -> Driver:
        return Right(self.robot, clock)


@pytest.mark.full
class TestRight(Suite):
    """The base of the wrong drivers passes the suite."""


@pytest.mark.full
class TestMovesSideways(Suite):
    """So does one with a robot that moves sideways."""

    def make_driver(self, clock: Clock) -> Driver:
        return robots.MovesSideways(self.robot, clock)


class Short(Suite):
    """Made without pytest's fixtures, and waiting less for what never comes."""

    def __init__(self, wrong: type[Right], monkeypatch: pytest.MonkeyPatch) -> None:
        for module in ("driver_under_test", "driver_safety"):
            monkeypatch.setattr(f"wax.testing.{module}.READY_S", 1.0)
            monkeypatch.setattr(f"wax.testing.{module}.HANGS_S", 2.0)
        monkeypatch.setattr("wax.testing.driver_under_test.MOVES_S", 1.0)
        self.begin()
        self.wrong = wrong
        self.made: list[Right] = []

    def make_driver(self, clock: Clock) -> Driver:
        self.made.append(self.wrong(self.robot, clock))
        return self.made[-1]

    def end(self) -> None:
        self.mend()
        self.robot.over.set()
        for thread in threading.enumerate():
            if thread.name == "bounded call":
                thread.join()
        for driver in self.made:
            driver.close()


@pytest.mark.parametrize(("wrong", "promise", "words"), WRONG)
def test_a_wrong_driver_is_caught(
    wrong: type[Right], promise: str, words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A driver that breaks a promise fails that promise's test, with a message that says how."""
    suite = Short(wrong, monkeypatch)
    try:
        with pytest.raises(Exception, match=words):
            getattr(suite, f"test_{promise}")(suite.make_driver(SystemClock()))
    finally:
        suite.end()


def test_every_promise_can_fail() -> None:
    """For each promise of the suite there is a driver that breaks it."""
    promises = {name for name in dir(DriverSafety) if name.startswith("test_")}
    assert {f"test_{promise}" for _, promise, _ in WRONG} == promises


def test_without_pytest_one_line_says_what_to_install() -> None:
    """Importing it without pytest raises a message with the line that installs it."""
    program = "import sys; sys.modules['pytest'] = None; import wax.testing"
    command = [sys.executable, "-c", program]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert 'pip install "wax-teleop[testing]"' in run.stderr
