"""The base class of a driver whose own thread talks to the robot; a subclass only says how.

The base class keeps the robot safe: turns, limits, silence, standstill after each connection,
repeated stops, and a thread that may block so that no caller has to.
"""

from __future__ import annotations

import contextlib
import threading
import time
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar, Final

import structlog

from wax.driver.checks import NO_ANSWER
from wax.driver.interface import STANDSTILL, Limits, RobotState
from wax.errors import reason_of
from wax.robot.line.setpoints import SetPoints
from wax.sentence import Sentence

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.config.robot import RobotSettings
    from wax.driver.interface import Pose, Twist
    from wax.robot.line.setpoints import Order

_LOG = structlog.get_logger(__name__)

TTL_S: Final = 0.3
"""Without a set-point for this long the robot is told to stop."""
RETRY_S: Final = 1.0
HUNG_S: Final = 1.0
CLOSE_S: Final = 0.8
FAREWELLS: Final = 3
FAREWELL_EVERY_S: Final = 0.02


@dataclass(frozen=True, slots=True)
class Reading:
    """The robot's answer, as far as it gives one; see `RobotState`."""

    moving: bool | None = None
    pose: Pose | None = None
    bumpers: int = 0
    battery_v: float | None = None
    battery_fraction: float | None = None
    extra: dict[str, float] = field(default_factory=dict)


class SteadyRobot(ABC):
    """A `Driver` for which a subclass has `connect`, `tell` and `disconnect`.

    A thread calls these, so each may block, `tell` for a twentieth of a second at most: it is
    called with each new set-point, and with the same one every `beat_s`. An exception means that
    the robot is lost; the text of an `OSError` is shown as the reason. They are called again a
    second later. The constructor of a subclass must touch no hardware.

    `robot_ttl_s` is the timeout after which the robot itself stops without a set-point, None if
    unknown. If it answers, it is lost after `silent_s` without an answer.
    """

    axes: ClassVar[tuple[str, ...]] = ()
    robot_ttl_s: ClassVar[float | None] = None
    silent_s: ClassVar[float | None] = None
    beat_s: ClassVar[float] = 0.05

    def __init__(self, settings: RobotSettings, clock: Clock) -> None:
        self.settings = settings
        self.clock = clock
        self._limits = Limits(
            settings.max_linear_mps,
            settings.max_angular_rps,
            axes=self.axes,
            ttl_s=self.robot_ttl_s,
        )
        self._lock = threading.Lock()
        self._setpoints = SetPoints(self._limits, TTL_S)
        self._news = threading.Event()
        self._closing = threading.Event()
        self._thread: threading.Thread | None = None
        self._left: threading.Thread | None = None
        self._calls_since_s: float | None = None
        self._heard_s = 0.0
        self._reading = Reading()
        self._connected = False
        self._problem: Sentence | None = None
        self._epoch = 0
        self._logged = ""

    # --- what a subclass has ----------------------------------------------------------------

    @abstractmethod
    def connect(self) -> None:
        """Connect to the robot."""

    @abstractmethod
    def tell(self, twist: Twist) -> Reading | None:
        """Send the robot this set-point or standstill; return its answer, if it has given one."""

    @abstractmethod
    def disconnect(self) -> None:
        """Disconnect from the robot, also after `connect` has failed half-way."""

    def move_axis(self, name: str, position: float) -> None:  # noqa: B027 - many robots have none
        """Move one of `axes` to a position in -1…1; called after each `tell`."""

    # --- the driver -------------------------------------------------------------------------

    @property
    def kind(self) -> str:
        return self.settings.driver

    @property
    def limits(self) -> Limits:
        return self._limits

    def open(self) -> None:
        if self._thread is not None:
            return
        self._closing = threading.Event()
        self._thread = threading.Thread(
            target=self._keep, args=(self._closing, self._left), name=self.kind, daemon=True
        )
        self._thread.start()

    def apply(self, twist: Twist, turn: int) -> None:
        with self._lock:
            self._setpoints.apply(twist, turn, self.clock.now_s())
        self._news.set()

    def set_axis(self, name: str, position: float, turn: int) -> None:
        with self._lock:
            self._setpoints.set_axis(name, position, turn)
        self._news.set()

    def stop(self, turn: int) -> None:
        with self._lock:
            self._setpoints.stop(turn)
        self._news.set()

    def close(self) -> None:
        thread, self._thread = self._thread, None
        if thread is None:
            return
        self._closing.set()
        self._news.set()
        thread.join(CLOSE_S)
        self._left = thread  # if it hangs, the next one waits for it
        self._lost(None)

    def state(self) -> RobotState:
        with self._lock:
            since_s = self._calls_since_s
            hangs = since_s is not None and self.clock.now_s() - since_s >= HUNG_S
            connected = self._connected and not hangs
            reading = self._reading if connected else Reading()
            return RobotState(
                connected=connected,
                problem=NO_ANSWER if hangs and self._thread else self._problem,
                epoch=self._epoch,
                moving=reading.moving,
                pose=reading.pose,
                bumpers=reading.bumpers,
                battery_v=reading.battery_v,
                battery_fraction=reading.battery_fraction,
                extra=reading.extra,
            )

    # --- the thread -------------------------------------------------------------------------

    def _keep(self, closing: threading.Event, left: threading.Thread | None) -> None:
        """Connect to the robot and talk to it, again and again until it is closed."""
        if left is not None:
            left.join()
        while not closing.is_set():
            try:
                self._converse(closing)
            except Exception as error:
                self._lost(Sentence("robot.not_reached", {"why": self._why(error)}))
            finally:
                with contextlib.suppress(Exception):
                    self.disconnect()
            closing.wait(RETRY_S)

    def _converse(self, closing: threading.Event) -> None:
        """Connect, and send set-points until it is closed; raises what the subclass raises."""
        self.connect()
        self._heard_s = self.clock.now_s()
        said: Order | None = None
        due_s = 0.0
        try:
            while not closing.is_set():
                now_s = self.clock.now_s()
                with self._lock:
                    order, changes_s = self._setpoints.order(now_s)
                if order != said or now_s >= due_s:
                    reading = self._say(order, said)
                    if not closing.is_set():
                        self._hear(reading, now_s)
                    said, due_s = order, now_s + self.beat_s
                self._news.wait(max(0.0, min(due_s, changes_s) - self.clock.now_s()))
                self._news.clear()
        finally:
            self._lost(None)
            with contextlib.suppress(Exception):
                for _ in range(FAREWELLS):  # one may be lost
                    self.tell(STANDSTILL)
                    time.sleep(FAREWELL_EVERY_S)

    def _say(self, order: Order, said: Order | None) -> Reading | None:
        """Send one order and return the answer; raises `TimeoutError` if that took too long."""
        start_s = self.clock.now_s()
        with self._lock:
            self._calls_since_s = start_s
        try:
            if said is not None and order.turn > said.turn and not order.twist.is_zero:
                self.tell(STANDSTILL)  # a starved thread may have skipped it
            reading = self.tell(order.twist)
            for name, position in order.axes:
                self.move_axis(name, position)
        finally:
            with self._lock:
                self._calls_since_s = None
        if self.clock.now_s() - start_s >= HUNG_S:
            raise TimeoutError("it took too long to answer")
        return reading

    def _hear(self, reading: Reading | None, now_s: float) -> None:
        """Count as connected while it answers or, if it never does, while nothing is raised."""
        if reading is not None:
            self._heard_s = now_s
        if self.silent_s is not None and now_s - self._heard_s >= self.silent_s:
            raise TimeoutError("it does not answer")
        with self._lock:
            if reading is not None:
                self._reading = reading
            if not self._connected and (reading is not None or self.silent_s is None):
                self._setpoints.connected()
                self._connected, self._problem, self._logged = True, None, ""
                self._epoch += 1

    def _lost(self, problem: Sentence | None) -> None:
        with self._lock:
            self._setpoints.lost()
            self._connected = False
            self._reading = Reading()
            self._problem = problem

    def _why(self, error: Exception) -> str:
        """Return why the robot is lost, and log it if the reason has changed."""
        why = reason_of(error)
        if why != self._logged:
            self._logged = why
            expected = isinstance(error, OSError)
            _LOG.warning("the robot is lost", problem=why, exc_info=None if expected else error)
        return why
