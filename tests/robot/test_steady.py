"""The base of drivers that talk to the robot in their own thread."""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING, ClassVar

import pytest
from tests.testing.robots import InMemory, Robot
from tests.until import until

from wax.clock import SystemClock
from wax.config.robot import RobotSettings
from wax.driver.interface import STANDSTILL, Twist
from wax.robot import steady
from wax.robot.steady import Reading, SteadyRobot

if TYPE_CHECKING:
    from collections.abc import Iterator

    from wax.clock import Clock
    from wax.driver.interface import Driver

AHEAD, BACK = Twist(0.3, 0.0), Twist(-0.3, 0.0)


class Mine(SteadyRobot):
    """Talks to a `Robot` in memory; `gate` makes it wait."""

    axes = ("pan",)

    def __init__(self, robot: Robot, clock: Clock) -> None:
        super().__init__(RobotSettings(driver="mine"), clock)
        self.robot = robot
        self.answers = True
        self.fault: Exception | None = None
        self.gate = threading.Event()
        self.gate.set()
        self.waits = False
        self.moved: list[tuple[str, float]] = []
        self.calls: list[str] = []

    def connect(self) -> None:
        self.calls.append("connect")
        self.robot.tell(STANDSTILL)

    def tell(self, twist: Twist) -> Reading | None:
        self.waits = not self.gate.is_set()
        self.gate.wait()
        if self.fault is not None:
            raise self.fault
        self.robot.tell(twist)
        return Reading(moving=not twist.is_zero, battery_v=7.4) if self.answers else None

    def move_axis(self, name: str, position: float) -> None:
        self.moved.append((name, position))

    def disconnect(self) -> None:
        self.calls.append("disconnect")


class Answering(Mine):
    silent_s: ClassVar[float | None] = 0.2


@pytest.mark.parametrize("can", [False, True])
def test_only_a_class_that_says_so_moves_sideways(*, can: bool) -> None:
    """Any other has no speed sideways, whatever the configuration asks for."""

    class Omni(Mine):
        moves_sideways: ClassVar[bool] = can

        def __init__(self) -> None:
            SteadyRobot.__init__(self, RobotSettings(driver="mine", base="omni"), SystemClock())

    assert Omni().limits.lateral_mps == (0.6 if can else 0.0)


@pytest.mark.system
class TestSteady(InMemory):
    made: ClassVar[type[Mine]] = Mine

    @pytest.fixture(autouse=True)
    def _robot(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(steady, "RETRY_S", 0.05)
        self.robot = Robot()

    def make_driver(self, clock: Clock) -> Driver:
        return self.made(self.robot, clock)


@pytest.mark.full
class TestAnswering(TestSteady):
    made = Answering


@pytest.fixture
def mine(monkeypatch: pytest.MonkeyPatch) -> Iterator[Answering]:
    for patience in ("TTL_S", "HUNG_S"):  # for a busy machine
        monkeypatch.setattr(steady, patience, 60.0)
    monkeypatch.setattr(steady, "RETRY_S", 0.01)
    monkeypatch.setattr(steady, "CLOSE_S", 0.1)
    robot = Answering(Robot(), SystemClock())
    yield robot
    robot.gate.set()
    robot.close()
    for thread in threading.enumerate():
        if thread.name == "mine":
            thread.join()


def opened(mine: Mine) -> Mine:
    mine.open()
    until(lambda: mine.state().connected)
    mine.apply(STANDSTILL, 1)
    return mine


@pytest.mark.system
def test_what_the_robot_answers_is_its_state(mine: Answering) -> None:
    """While it is connected, its state is its last answer."""
    opened(mine).apply(AHEAD, 1)
    until(lambda: mine.state().moving is True)
    assert mine.state().battery_v == 7.4
    mine.close()
    assert mine.state().moving is None


@pytest.mark.system
def test_an_axis_is_moved(mine: Answering) -> None:
    """The position of an axis reaches the robot."""
    opened(mine).set_axis("pan", 0.5, 1)
    until(lambda: ("pan", 0.5) in mine.moved)


@pytest.mark.system
def test_a_robot_that_does_not_answer_is_lost(mine: Answering) -> None:
    """Without answers it is lost and reconnected; meanwhile nothing moves it."""
    opened(mine).apply(AHEAD, 1)
    until(lambda: mine.robot.take()[-1:] != [STANDSTILL])
    mine.answers = False
    until(lambda: not mine.state().connected)
    until(lambda: "does not answer" in str(mine.state().problem))
    mine.robot.take()
    mine.apply(AHEAD, 1)
    time.sleep(0.1)
    assert all(twist.is_zero for twist in mine.robot.take())
    mine.answers = True
    until(lambda: mine.state().connected)
    assert mine.state().epoch >= 2
    assert mine.calls[:3] == ["connect", "disconnect", "connect"]


@pytest.mark.system
def test_a_call_that_hangs_is_a_lost_robot(
    mine: Answering, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A robot whose `tell` hangs is not connected, and its set-point is dropped."""
    opened(mine).apply(AHEAD, 1)
    until(lambda: mine.state().moving is True)
    mine.gate.clear()
    monkeypatch.setattr(steady, "HUNG_S", 0.1)
    until(lambda: not mine.state().connected)
    assert mine.state().problem is not None
    for _ in range(5):
        mine.apply(AHEAD, 1)
        time.sleep(0.02)
    mine.robot.take()
    mine.gate.set()
    until(lambda: mine.state().epoch >= 2)
    time.sleep(0.05)
    assert [twist for twist in mine.robot.take() if not twist.is_zero] in ([], [AHEAD])


@pytest.mark.system
def test_closing_does_not_wait_for_a_call_that_hangs(mine: Answering) -> None:
    """Closing returns at once; the next thread waits for the abandoned one."""
    opened(mine)
    mine.gate.clear()
    start_s = time.monotonic()
    mine.close()
    mine.open()
    assert time.monotonic() - start_s < 1.0
    time.sleep(0.05)
    assert mine.calls.count("connect") == 1
    mine.gate.set()
    until(lambda: mine.state().epoch >= 2)
    assert mine.state().connected


@pytest.mark.system
@pytest.mark.parametrize(
    ("fault", "words"), [(OSError(5, "the plug is out"), "the plug is out"), (KeyError("a"), "'a'")]
)
def test_what_a_subclass_raises_is_reported(mine: Answering, fault: Exception, words: str) -> None:
    """An exception disconnects the robot, with its text; afterwards it reconnects."""
    opened(mine)
    mine.fault = fault
    until(lambda: words in str(mine.state().problem))
    assert not mine.state().connected
    mine.fault = None
    until(lambda: mine.state().connected)
    assert mine.state().problem is None


@pytest.mark.system
def test_between_two_turns_it_gets_standstill(mine: Answering) -> None:
    """A set-point of a new turn does not replace a stop that was not sent yet."""
    opened(mine).apply(AHEAD, 1)
    until(lambda: mine.state().moving is True)
    mine.gate.clear()
    until(lambda: mine.waits)
    mine.robot.take()
    mine.apply(STANDSTILL, 2)
    mine.apply(BACK, 2)
    mine.gate.set()
    told: list[Twist] = []

    def turned_back() -> bool:
        told.extend(mine.robot.take())
        return BACK in told

    until(turned_back)
    assert told.index(STANDSTILL) < told.index(BACK)
