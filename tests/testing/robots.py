"""A robot in memory, a correct driver, and wrong drivers that break one promise each."""

from __future__ import annotations

import math
import threading
import time
from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar

from wax.driver.interface import STANDSTILL, Limits, RobotState
from wax.robot.line.setpoints import SetPoints
from wax.testing import DriverSafety

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.clock import Clock
    from wax.driver.interface import Twist

LIMITS = Limits(0.6, 1.5, axes=("pan",))
SIDEWAYS = replace(LIMITS, lateral_mps=0.4)


class Robot:
    """The robot's end of a link that can be cut; it records set-points."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._told: list[Twist] = []
        self.is_cut = False
        self.over = threading.Event()
        """Set when the test is over, to release waiting threads."""

    def tell(self, twist: Twist) -> None:
        """Take a set-point; raises `OSError` while the link is cut."""
        with self._lock:
            if self.is_cut:
                raise OSError("the link is cut")
            self._told.append(twist)

    def take(self) -> list[Twist]:
        """Return what it was told since the last call."""
        with self._lock:
            told, self._told = self._told, []
            return told


class InMemory(DriverSafety):
    """The suite, of a driver of the `robot`."""

    robot: Robot

    def commanded(self) -> Sequence[Twist]:
        return self.robot.take()

    def cut(self) -> None:
        self.robot.is_cut = True

    def mend(self) -> None:
        self.robot.is_cut = False


class Right:
    """A driver of a `Robot` that keeps every promise: a thread repeats what `SetPoints` allows."""

    period_s: ClassVar = 0.01
    ttl_s: ClassVar = 0.3
    own_limits: ClassVar = LIMITS

    def __init__(self, robot: Robot, clock: Clock) -> None:
        self.robot = robot
        self.clock = clock
        self.lock = threading.Lock()
        self.setpoints = SetPoints(self.own_limits, self.ttl_s)
        self.answer = RobotState(connected=False)
        self.closing = threading.Event()
        self.thread: threading.Thread | None = None

    @property
    def kind(self) -> str:
        return "in memory"

    @property
    def limits(self) -> Limits:
        return self.own_limits

    def open(self) -> None:
        if self.thread is None:
            self.closing = threading.Event()
            self.thread = threading.Thread(target=self.live, name="in memory", daemon=True)
            self.thread.start()

    def apply(self, twist: Twist, turn: int) -> None:
        with self.lock:
            self.setpoints.apply(twist, turn, self.clock.now_s())

    def set_axis(self, name: str, position: float, turn: int) -> None:
        with self.lock:
            self.setpoints.set_axis(name, position, turn)

    def stop(self, turn: int) -> None:
        with self.lock:
            self.setpoints.stop(turn)

    def close(self) -> None:
        thread, self.thread = self.thread, None
        if thread is not None:
            self.closing.set()
            thread.join(1.0)
            self.connect(to=False)

    def state(self) -> RobotState:
        return self.answer

    def live(self) -> None:
        while not self.closing.wait(self.period_s):
            try:
                self.say()
            except OSError as error:
                self.connect(to=False, problem=f"The robot does not answer: {error}.")
            else:
                self.connect(to=True)
        self.farewell()

    def say(self) -> None:
        with self.lock:
            order, _ = self.setpoints.order(self.clock.now_s())
            self.robot.tell(order.twist)

    def farewell(self) -> None:
        if not self.robot.is_cut:
            self.robot.tell(STANDSTILL)

    def connect(self, *, to: bool, problem: str | None = None) -> None:
        with self.lock:
            if self.answer.connected != to:
                (self.setpoints.connected if to else self.setpoints.lost)()
            epoch = self.answer.epoch + (to and not self.answer.connected)
            self.answer = RobotState(connected=to, problem=problem, epoch=epoch)


class _Remembers(Right):
    """Also keeps the newest set-point itself, so that a subclass can break a rule."""

    wanted = STANDSTILL
    turn = 0

    def apply(self, twist: Twist, turn: int) -> None:
        super().apply(twist, turn)
        self.wanted, self.turn = twist, turn

    def stop(self, turn: int) -> None:
        super().stop(turn)
        self.wanted = STANDSTILL


class MovesWhenOpened(Right):
    def connect(self, *, to: bool, problem: str | None = None) -> None:
        if to and not self.answer.connected:
            self.robot.tell(replace(STANDSTILL, linear_mps=0.1))
        super().connect(to=to, problem=problem)


class GoesTheWrongWay(Right):
    def apply(self, twist: Twist, turn: int) -> None:
        super().apply(replace(twist, linear_mps=abs(twist.linear_mps)), turn)


class KnowsNoLimitsYet(Right):
    @property
    def limits(self) -> Limits:
        return LIMITS if self.thread else replace(LIMITS, linear_mps=0.0)


class HasNoEndOfItsSpeed(Right):
    @property
    def limits(self) -> Limits:
        return replace(LIMITS, linear_mps=math.inf)


class ConnectsWhenBuilt(Right):
    def __init__(self, robot: Robot, clock: Clock) -> None:
        super().__init__(robot, clock)
        self.open()


class DisturbsTheOther(Right):
    """Two instances cannot exist at once, as if the constructor claimed pins."""

    first: ClassVar[dict[Robot, Right]] = {}

    def __init__(self, robot: Robot, clock: Clock) -> None:
        super().__init__(robot, clock)
        first = self.first.setdefault(robot, self)
        if first.thread is not None:
            first.close()


class RaisesWhenClosed(Right):
    def stop(self, turn: int) -> None:
        if self.thread is None:
            raise OSError("the port is closed")
        super().stop(turn)


class RaisesForAnUnknownAxis(Right):
    def set_axis(self, name: str, position: float, turn: int) -> None:
        dict.fromkeys(LIMITS.axes)[name]
        super().set_axis(name, position, turn)


class RefusesAnOldStop(Right):
    highest = 0

    def apply(self, twist: Twist, turn: int) -> None:
        self.highest = max(self.highest, turn)
        super().apply(twist, turn)

    def stop(self, turn: int) -> None:
        if turn >= self.highest:
            super().stop(turn)


class StopsLate(Right):
    period_s = 0.25


class StopsBySilence(Right):
    """Sends nothing after a stop, and relies on the robot's own watchdog."""

    def say(self) -> None:
        with self.lock:
            order, _ = self.setpoints.order(self.clock.now_s())
            if not order.twist.is_zero or not self.answer.connected:
                self.robot.tell(order.twist)

    def farewell(self) -> None:
        """Say nothing."""


class SaysAStopOnce(Right):
    said: Twist | None = None

    def say(self) -> None:
        with self.lock:
            order, _ = self.setpoints.order(self.clock.now_s())
            if order.twist != self.said or not order.twist.is_zero:
                self.robot.tell(order.twist)
                self.said = order.twist


class FollowsAnOldTurn(Right):
    def apply(self, twist: Twist, turn: int) -> None:
        super().apply(twist, 99)


class IsKeptGoingByAnOldTurn(_Remembers):
    """Does not follow an old turn, but lets it reset the silence timeout."""

    def apply(self, twist: Twist, turn: int) -> None:
        newest = turn >= self.turn
        kept = self.wanted, self.turn
        super().apply(*((twist, turn) if newest else kept))


class HasNoWatchdog(Right):
    ttl_s = math.inf


class MovesByWhatIsNoNumber(_Remembers):
    def say(self) -> None:
        if self.answer.connected and not math.isfinite(self.wanted.linear_mps):
            self.robot.tell(self.wanted)
        else:
            super().say()


class IsKeptGoingByNoNumber(_Remembers):
    def apply(self, twist: Twist, turn: int) -> None:
        finite = math.isfinite(twist.linear_mps) and math.isfinite(twist.angular_rps)
        super().apply(twist if finite else self.wanted, turn)


class HasNoLimits(_Remembers):
    def say(self) -> None:
        with self.lock:
            order, _ = self.setpoints.order(self.clock.now_s())
            self.robot.tell(STANDSTILL if order.twist.is_zero else self.wanted)


class BlocksWhileItWrites(Right):
    def apply(self, twist: Twist, turn: int) -> None:
        time.sleep(0.01)
        super().apply(twist, turn)


class BlocksWhileItOpens(Right):
    def open(self) -> None:
        time.sleep(0.6)
        super().open()


class HangsWhenAsked(Right):
    def state(self) -> RobotState:
        if threading.current_thread().name == "bounded call":
            self.robot.over.wait()
        return self.answer


class WaitsForTheRobot(Right):
    def open(self) -> None:
        while self.robot.is_cut:
            time.sleep(0.01)
        super().open()


class NeverEndsClosing(Right):
    def close(self) -> None:
        if self.thread is not None:
            time.sleep(1.1)
        super().close()


class ClosesWithoutAStop(Right):
    def farewell(self) -> None:
        """Say nothing."""


class StaysConnected(Right):
    def close(self) -> None:
        connected = self.answer
        super().close()
        self.answer = connected


class OpensAgainByItself(Right):
    was_open = False

    def apply(self, twist: Twist, turn: int) -> None:
        if self.was_open and self.thread is None:
            self.open()
        self.was_open = self.was_open or self.thread is not None
        super().apply(twist, turn)


class GoesOnWhereItWas(_Remembers):
    """Sends the last set-point again as soon as it has reconnected."""

    def connect(self, *, to: bool, problem: str | None = None) -> None:
        again = to and not self.answer.connected and self.answer.epoch > 0
        super().connect(to=to, problem=problem)
        if again:
            self.robot.tell(self.wanted)


class CountsNoConnections(Right):
    def connect(self, *, to: bool, problem: str | None = None) -> None:
        super().connect(to=to, problem=problem)
        self.answer = replace(self.answer, epoch=1)


class DoesNotNoticeTheCut(Right):
    def connect(self, *, to: bool, problem: str | None = None) -> None:
        super().connect(to=to or bool(problem), problem=None)


class SaysNoProblem(Right):
    def connect(self, *, to: bool, problem: str | None = None) -> None:
        super().connect(to=to, problem=None)


class ForgetsWhoseTurnItIs(FollowsAnOldTurn):
    """Follows every thread that still asks."""


class HasNoStateForAnother(Right):
    """Raises if another thread than the one that opened it asks for the state."""

    def state(self) -> RobotState:
        if threading.current_thread().name == "asks for the state":
            raise RuntimeError("dictionary changed size during iteration")
        return self.answer


class SaysWhatCannotBeSent(Right):
    def state(self) -> RobotState:
        broken: Any = object()
        return replace(self.answer, extra={"driven_m": broken}) if self.thread else self.answer


class MovesSideways(Right):
    """Keeps every promise, too, with a robot that moves sideways."""

    own_limits = SIDEWAYS


class NeverMovesSideways(MovesSideways):
    def apply(self, twist: Twist, turn: int) -> None:
        super().apply(replace(twist, lateral_mps=0.0), turn)


class GoesRightForLeft(MovesSideways):
    def apply(self, twist: Twist, turn: int) -> None:
        super().apply(replace(twist, lateral_mps=-twist.lateral_mps), turn)


class HasNoEndSideways(Right):
    @property
    def limits(self) -> Limits:
        return replace(LIMITS, lateral_mps=math.inf)


class MovesSidewaysUnasked(Right):
    """Follows a motion that its limits deny."""

    def __init__(self, robot: Robot, clock: Clock) -> None:
        super().__init__(robot, clock)
        self.setpoints = SetPoints(SIDEWAYS, self.ttl_s)


class IsFasterOnTheDiagonal(MovesSideways, _Remembers):
    def say(self) -> None:
        with self.lock:
            order, _ = self.setpoints.order(self.clock.now_s())
            ahead, left = (
                min(most, max(-most, asked))
                for asked, most in ((self.wanted.linear_mps, 0.6), (self.wanted.lateral_mps, 0.4))
            )
            moving = replace(order.twist, linear_mps=ahead, lateral_mps=left)
            self.robot.tell(STANDSTILL if order.twist.is_zero else moving)


class _DriftsOn(MovesSideways):
    """Holds on to a speed sideways."""

    drift_mps = 0.0

    def say(self) -> None:
        with self.lock:
            order, _ = self.setpoints.order(self.clock.now_s())
            self.robot.tell(replace(order.twist, lateral_mps=self.drift_mps))


class DriftsOnAfterAStop(_DriftsOn):
    def apply(self, twist: Twist, turn: int) -> None:
        super().apply(twist, turn)
        self.drift_mps = twist.lateral_mps or self.drift_mps


class DriftsOnInSilence(_DriftsOn):
    def apply(self, twist: Twist, turn: int) -> None:
        super().apply(twist, turn)
        self.drift_mps = twist.lateral_mps

    def stop(self, turn: int) -> None:
        super().stop(turn)
        self.drift_mps = 0.0


class DriftsOnByNoNumber(DriftsOnInSilence):
    """Takes what is no number for nothing new, and notices silence."""

    def apply(self, twist: Twist, turn: int) -> None:
        bad = not math.isfinite(twist.lateral_mps)
        super().apply(replace(twist, lateral_mps=self.drift_mps) if bad else twist, turn)


class FollowsAnOldTurnSideways(MovesSideways):
    def apply(self, twist: Twist, turn: int) -> None:
        super().apply(twist, 99 if twist.lateral_mps else turn)
