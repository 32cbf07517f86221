"""The driver for a robot on a serial port."""

from __future__ import annotations

from typing import TYPE_CHECKING

import structlog

from wax.config.as_toml import as_toml
from wax.driver.interface import Limits, Reading
from wax.errors import ConfigError
from wax.robot.line.core import LineCore
from wax.robot.line.robot import LineRobot
from wax.robot.serial.advice import advised
from wax.robot.serial.bytes_dialect import BytesDialect
from wax.robot.serial.frames_dialect import FramesDialect
from wax.robot.serial.odometry import Odometry
from wax.robot.serial.port_line import CLOSE_TIMEOUT_S, PortLine
from wax.robot.serial.text_dialect import TextDialect
from wax.robot.wheels import WheelMixer

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.config.robot import RobotSettings
    from wax.config.serial import SerialSettings
    from wax.robot.serial.dialect import Dialect

_LOG = structlog.get_logger(__name__)


class SerialRobot(LineRobot):
    """A `Driver` for any URL that pyserial opens, in one of three dialects.

    With ``frames``, or with ``text`` and a robot configured to answer, the robot is connected while
    it answers; otherwise while the port is open. After connecting, nothing moves until a set-point
    of standstill (`stop`, or `apply` of zero). Without a set-point for `ttl_ms` it stops the robot.
    """

    def __init__(self, settings: RobotSettings, clock: Clock) -> None:
        serial = settings.serial
        _refuse_sideways(settings)
        limits = Limits(
            settings.max_linear_mps,
            settings.max_angular_rps,
            axes=() if serial.dialect == "bytes" else tuple(serial.axes),
            ttl_s=_own_watchdog_s(serial),
            lateral_mps=settings.lateral_mps,
        )
        core = SerialCore(_dialect(settings, limits), limits, serial)
        super().__init__(
            "serial",
            limits,
            clock,
            core,
            PortLine(serial, clock, core),
            reopen_s=serial.reopen_s,
            close_s=CLOSE_TIMEOUT_S,
        )
        self._advice = advised(serial)

    def open(self) -> None:
        for one in self._advice:
            _LOG.warning(f"{one.problem}. {one.remedy}.")
        super().open()


class SerialCore(LineCore):
    """The `PortConversation` of a serial robot: its dialect says what `LineCore` orders."""

    def __init__(self, dialect: Dialect, limits: Limits, serial: SerialSettings) -> None:
        super().__init__(limits, serial.ttl_ms / 1000.0)
        self._dialect = dialect
        self._url = serial.url

    def hello(self, now_s: float) -> bytes:
        with self._lock:
            self._is_open = True
            words = self._dialect.hello(now_s)
            self._look(now_s)
            return words

    def next(self, now_s: float) -> tuple[bytes, float]:
        with self._lock:
            self._look(now_s)
            order, changes_s = self._setpoints.order(now_s)
            words, due_s = self._dialect.data_to_send(order, now_s)
            return words, min(due_s, changes_s)

    def received(self, data: bytes, now_s: float) -> None:
        with self._lock:
            self._dialect.receive_data(data, now_s)
            self._look(now_s)

    def farewell(self) -> bytes:
        with self._lock:
            return self._dialect.farewell()

    def _reading(self, now_s: float) -> Reading:  # noqa: ARG002 - of the base class
        return self._dialect.reading

    def _look(self, now_s: float) -> None:
        """Update whether the robot is connected."""
        if self._dialect.answers(now_s):
            self._connect()
        elif self._dialect.overdue(now_s):
            self._disconnect(self._dialect.complaint(self._url))


def _own_watchdog_s(serial: SerialSettings) -> float | None:
    """Return the board's own watchdog timeout, None if it has none or none is known."""
    if serial.dialect == "frames":
        return serial.ttl_ms / 1000.0
    if serial.dialect == "text" and serial.text.ttl_ms:
        return serial.text.ttl_ms / 1000.0
    return None  # the board follows a byte for ever


def _refuse_sideways(settings: RobotSettings) -> None:
    """Raise `ConfigError` if the robot is to move sideways, but its dialect cannot say so."""
    serial = settings.serial
    match serial.dialect:
        case "bytes":
            lacking = 'serial.dialect = "bytes" has no byte'
        case "text" if not serial.text.moves_sideways:
            lacking = f"serial.text.drive = {as_toml(serial.text.drive)} has no {{lateral}}"
        case _:
            return
    if settings.lateral_mps > 0:
        raise ConfigError(
            f"robot.max_lateral_mps: {lacking} to move this robot sideways; set it to 0, or see"
            " robot.serial."
        )


def _refuse_mixing(settings: RobotSettings) -> None:
    """Refuse what is done to wheels here for a board that mixes them; raises `ConfigError`."""
    for key in ("left_trim", "right_trim", "invert_left", "invert_right"):
        if getattr(settings, key) != type(settings).model_fields[key].default:
            raise ConfigError(
                f"robot.{key}: the board turns the wheels of this base by itself; leave it out, and"
                " for a motor that turns the wrong way swap its two pins in the board's config.h"
            )


def _dialect(settings: RobotSettings, limits: Limits) -> Dialect:
    serial = settings.serial
    if serial.dialect == "frames":
        moves_sideways = limits.lateral_mps > 0
        if moves_sideways:
            _refuse_mixing(settings)
        # Its drives and reports have the speeds and the ticks of two sides.
        mixer, odometry = WheelMixer(settings, "differential"), Odometry(settings, "differential")
        return FramesDialect(
            *(mixer, serial.ttl_ms, limits.axes, odometry), moves_sideways=moves_sideways
        )
    if serial.dialect == "text":
        return TextDialect(settings, WheelMixer(settings), limits)
    return BytesDialect(serial.bytes, limits)
