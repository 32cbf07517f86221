"""The driver for a robot on a serial port."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

import structlog

from wax.driver.interface import Limits, RobotState
from wax.robot.line.setpoints import SetPoints
from wax.robot.serial.advice import advised
from wax.robot.serial.bytes_dialect import BytesDialect
from wax.robot.serial.frames_dialect import FramesDialect
from wax.robot.serial.odometry import Odometry
from wax.robot.serial.reconnecting_port import Port
from wax.robot.serial.text_dialect import TextDialect
from wax.robot.wheels import WheelMixer

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.config.robot import RobotSettings
    from wax.config.serial import SerialSettings
    from wax.driver.interface import Twist
    from wax.errors import DriverError
    from wax.robot.serial.dialect import Dialect
    from wax.sentence import Sentence

_LOG = structlog.get_logger(__name__)


class SerialRobot:
    """A `Driver` for any URL that pyserial opens, in one of three dialects.

    With ``frames``, or with ``text`` and a robot configured to answer, the robot is connected while
    it answers; otherwise while the port is open. After connecting, nothing moves until a set-point
    of standstill (`stop`, or `apply` of zero). Without a set-point for `ttl_ms` it stops the robot.
    """

    def __init__(self, settings: RobotSettings, clock: Clock) -> None:
        serial = settings.serial
        self._limits = Limits(
            settings.max_linear_mps,
            settings.max_angular_rps,
            axes=() if serial.dialect == "bytes" else tuple(serial.axes),
            ttl_s=_own_watchdog_s(serial),
        )
        dialect = _dialect(settings, self._limits)
        self._clock = clock
        self._conversation = _SerialConversation(
            dialect, SetPoints(self._limits, serial.ttl_ms / 1000.0), serial.url
        )
        self._port = Port(serial, clock, self._conversation)
        self._advice = advised(serial)

    @property
    def kind(self) -> str:
        return "serial"

    @property
    def limits(self) -> Limits:
        return self._limits

    def open(self) -> None:
        """Start opening the port; `state` reports whether it is open."""
        for one in self._advice:
            _LOG.warning(f"{one.problem}. {one.remedy}.")
        self._port.open()

    def apply(self, twist: Twist, turn: int) -> None:
        with self._conversation.lock:
            self._conversation.setpoints.apply(twist, turn, self._clock.now_s())
        self._port.wake()

    def set_axis(self, name: str, position: float, turn: int) -> None:
        with self._conversation.lock:
            self._conversation.setpoints.set_axis(name, position, turn)
        self._port.wake()

    def stop(self, turn: int) -> None:
        with self._conversation.lock:
            self._conversation.setpoints.stop(turn)
        self._port.wake()

    def close(self) -> None:
        self._port.close()
        self._conversation.close()

    def state(self) -> RobotState:
        return self._conversation.state()


class _SerialConversation:
    """The `Conversation` of a serial robot: set-points in, the dialect's bytes out, one lock."""

    def __init__(self, dialect: Dialect, setpoints: SetPoints, url: str) -> None:
        self.lock = threading.Lock()
        self.setpoints = setpoints
        self._dialect = dialect
        self._url = url
        self._connected = False
        self._problem: Sentence | None = None
        self._epoch = 0

    def opened(self, now_s: float) -> bytes:
        with self.lock:
            words = self._dialect.hello(now_s)
            self._look(now_s)
            return words

    def next(self, now_s: float) -> tuple[bytes, float]:
        with self.lock:
            self._look(now_s)
            order, changes_s = self.setpoints.order(now_s)
            words, due_s = self._dialect.data_to_send(order, now_s)
            return words, min(due_s, changes_s)

    def received(self, data: bytes, now_s: float) -> None:
        with self.lock:
            self._dialect.receive_data(data, now_s)
            self._look(now_s)

    def lost(self, problem: DriverError) -> None:
        with self.lock:
            self._disconnect(problem.sentence)

    def farewell(self) -> bytes:
        with self.lock:
            return self._dialect.farewell()

    def close(self) -> None:
        with self.lock:
            self._disconnect(None)

    def state(self) -> RobotState:
        with self.lock:
            return RobotState(
                connected=self._connected,
                problem=self._problem,
                epoch=self._epoch,
                moving=self._dialect.moving if self._connected else None,
                pose=self._dialect.pose if self._connected else None,
                bumpers=self._dialect.bumpers if self._connected else 0,
                battery_v=self._dialect.battery_v if self._connected else None,
                extra=self._dialect.known(),
            )

    def _look(self, now_s: float) -> None:
        """Update whether the robot is connected."""
        if self._dialect.answers(now_s):
            if not self._connected:
                self.setpoints.connected()
                self._connected, self._problem = True, None
                self._epoch += 1
        elif self._dialect.overdue(now_s):
            self._disconnect(self._dialect.complaint(self._url))

    def _disconnect(self, problem: Sentence | None) -> None:
        self.setpoints.lost()
        self._connected, self._problem = False, problem


def _own_watchdog_s(serial: SerialSettings) -> float | None:
    """Return the board's own watchdog timeout, None if it has none or none is known."""
    if serial.dialect == "frames":
        return serial.ttl_ms / 1000.0
    if serial.dialect == "text" and serial.text.ttl_ms:
        return serial.text.ttl_ms / 1000.0
    return None  # the board follows a byte for ever


def _dialect(settings: RobotSettings, limits: Limits) -> Dialect:
    mixer, serial = WheelMixer(settings), settings.serial
    if serial.dialect == "frames":
        return FramesDialect(mixer, serial.ttl_ms, limits.axes, Odometry(settings))
    if serial.dialect == "text":
        return TextDialect(settings, mixer, limits)
    return BytesDialect(serial.bytes, limits)
