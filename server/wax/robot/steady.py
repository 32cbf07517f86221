"""The base class of a driver whose own thread talks to the robot; a subclass only says how.

The base class keeps the robot safe: turns, limits, silence, standstill after each connection,
repeated stops, and a thread that may block so that no caller has to.
"""

from __future__ import annotations

import contextlib
import time
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar, Final

import structlog

from wax.driver.checks import NO_ANSWER
from wax.driver.interface import STANDSTILL, Limits, Reading, RobotState
from wax.errors import reason_of
from wax.robot.line.core import LineCore
from wax.robot.line.kept_line import RobotLine
from wax.robot.line.robot import LineRobot
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.clock import Clock
    from wax.config.robot import RobotSettings
    from wax.driver.interface import Twist
    from wax.robot.line.setpoints import Order

__all__ = ["Reading", "SteadyRobot"]

_LOG = structlog.get_logger(__name__)

TTL_S: Final = 0.3
"""Without a set-point for this long the robot is told to stop."""
RETRY_S: Final = 1.0
HUNG_S: Final = 1.0
CLOSE_S: Final = 0.8
FAREWELLS: Final = 3
FAREWELL_EVERY_S: Final = 0.02


class SteadyRobot(LineRobot, ABC):
    """A `Driver` for which a subclass has `connect`, `tell` and `disconnect`.

    A thread calls these, so each may block, `tell` for a twentieth of a second at most: it is
    called with each new set-point, and with the same one every `beat_s`. An exception means that
    the robot is lost; the text of an `OSError` is shown as the reason. They are called again a
    second later. The constructor of a subclass must touch no hardware.

    A class with `moves_sideways` is told `Twist.lateral_mps`, within `[robot] max_lateral_mps`; to
    any other it is always 0. `robot_ttl_s` is the timeout after which the robot itself stops
    without a set-point, None if unknown. If it answers, it is lost after `silent_s` without an
    answer.
    """

    axes: ClassVar[tuple[str, ...]] = ()
    moves_sideways: ClassVar[bool] = False
    robot_ttl_s: ClassVar[float | None] = None
    silent_s: ClassVar[float | None] = None
    beat_s: ClassVar[float] = 0.05

    def __init__(self, settings: RobotSettings, clock: Clock) -> None:
        self.settings = settings
        self.clock = clock
        limits = Limits(
            settings.max_linear_mps,
            settings.max_angular_rps,
            axes=self.axes,
            ttl_s=self.robot_ttl_s,
            lateral_mps=settings.lateral_mps if self.moves_sideways else 0.0,
        )
        core = LineCore(limits, TTL_S)
        self._calls = _Calls(self, core)
        super().__init__(
            settings.driver, limits, clock, core, self._calls, reopen_s=RETRY_S, close_s=CLOSE_S
        )

    @abstractmethod
    def connect(self) -> None:
        """Connect to the robot."""

    @abstractmethod
    def tell(self, twist: Twist) -> Reading | None:
        """Send the robot this set-point or standstill; return its answer, if it has given one."""

    @abstractmethod
    def disconnect(self) -> None:
        """Disconnect from the robot, also after `connect` has failed half-way."""

    def move_axis(self, name: str, position: float) -> None:
        """Move one of `axes` to a position in -1…1; called after each `tell`."""

    def state(self) -> RobotState:
        state = super().state()
        if not self._calls.hang():
            return state
        problem = NO_ANSWER if self._kept.is_open else state.problem
        return RobotState(connected=False, problem=problem, epoch=state.epoch)


class _Calls(RobotLine):
    """The calls of a subclass's own methods, as a line."""

    def __init__(self, robot: SteadyRobot, core: LineCore) -> None:
        self._robot = robot
        self._core = core
        self._since_s: float | None = None
        self._heard_s = self._due_s = 0.0
        self._said: Order | None = None
        self._logged = ""

    def hang(self) -> bool:
        """Whether one of them has not returned for too long."""
        since_s = self._since_s
        return since_s is not None and self._robot.clock.now_s() - since_s >= HUNG_S

    def open(self, wake: Callable[[], None]) -> None:  # noqa: ARG002 - of the base class
        try:
            self._robot.connect()
        except Exception:
            self.close()
            raise

    def begin(self, now_s: float) -> None:
        self._heard_s, self._due_s, self._said = now_s, now_s, None
        self._core.opened(now_s)

    def step(self, now_s: float) -> float:
        order, changes_s = self._core.order(now_s)
        if order != self._said or now_s >= self._due_s:
            self._hear(self._say(order), now_s)
            self._said, self._due_s = order, now_s + self._robot.beat_s
        return min(self._due_s, changes_s)

    def leave(self, now_s: float) -> float:  # noqa: ARG002 - it is said at once
        self._core.lost(None)
        with contextlib.suppress(Exception):
            for _ in range(FAREWELLS):  # one may be lost
                self._robot.tell(STANDSTILL)
                time.sleep(FAREWELL_EVERY_S)
        return 0.0

    def last_words(self, error: Exception) -> None:  # noqa: ARG002 - whatever it was
        self.leave(0.0)

    def close(self) -> None:
        with contextlib.suppress(Exception):
            self._robot.disconnect()

    def problem(self, error: Exception, *, was_open: bool) -> Sentence:  # noqa: ARG002
        """Return why the robot is lost, and log it if the reason has changed."""
        why = reason_of(error)
        if why != self._logged:
            self._logged = why
            expected = isinstance(error, OSError)
            _LOG.warning("the robot is lost", problem=why, exc_info=None if expected else error)
        return Sentence("robot.not_reached", {"why": why})

    def _say(self, order: Order) -> Reading | None:
        """Send one order and return the answer; raises `TimeoutError` if that took too long."""
        start_s = self._since_s = self._robot.clock.now_s()
        try:
            if self._said is not None and order.turn > self._said.turn and not order.twist.is_zero:
                self._robot.tell(STANDSTILL)  # a starved thread may have skipped it
            reading = self._robot.tell(order.twist)
            for name, position in order.axes:
                self._robot.move_axis(name, position)
        finally:
            self._since_s = None
        if self._robot.clock.now_s() - start_s >= HUNG_S:
            raise TimeoutError("it took too long to answer")
        return reading

    def _hear(self, reading: Reading | None, now_s: float) -> None:
        """Count as connected while it answers or, if it never does, while nothing is raised."""
        if reading is not None:
            self._heard_s = now_s
        silent_s = self._robot.silent_s
        if silent_s is not None and now_s - self._heard_s >= silent_s:
            raise TimeoutError("it does not answer")
        if reading is not None or silent_s is None:
            self._core.heard(reading)
            self._logged = ""
