"""The dialect ``frames``: negotiates a session, sends changes at once, and repeats everything."""

from __future__ import annotations

import secrets
from collections import deque
from typing import TYPE_CHECKING, Final

from wax.driver.interface import Reading
from wax.robot.serial.frames import (
    NO_SESSION,
    POSITION_SCALE,
    AxisBody,
    Body,
    Decoder,
    DriveBody,
    Frame,
    HelloBody,
    MoveBody,
    ReportBody,
    StopBody,
    encode,
)
from wax.sentence import Sentence

if TYPE_CHECKING:
    from wax.robot.line.setpoints import Order
    from wax.robot.serial.odometry import Odometry
    from wax.robot.wheels import WheelMixer

HELLO_EVERY_S: Final = 0.1
DRIVE_EVERY_S: Final = 0.02
STOP_EVERY_S: Final = 0.05
SILENT_AFTER_S: Final = 0.5
REMEMBERED: Final = 256
"""Sent frames to remember: more than half a second's worth, axes included."""
_CLOCK_WRAPS_MS: Final = 2**32


class FramesDialect:
    """A `Dialect` for boards with their own watchdog.

    The robot is connected while its reports acknowledge a frame sent within the last
    `SILENT_AFTER_S`, which proves both directions. Until then it gets only hello and stop. After a
    silence, or after its own watchdog stopped it, they start a new session: a robot that stopped
    itself must not start by itself.

    If it `moves_sideways`, it is sent each motion as a move, and a board that does not obey these
    is not connected. From two encoders nobody can tell where such a robot is.
    """

    def __init__(
        self,
        mixer: WheelMixer,
        ttl_ms: int,
        axes: tuple[str, ...],
        odometry: Odometry,
        *,
        moves_sideways: bool = False,
    ) -> None:
        self._mixer = mixer
        self._odometry = odometry
        self._axes = axes
        self._ttl_ms = ttl_ms
        self._moves_sideways = moves_sideways
        self._cannot = False
        self._session = NO_SESSION
        self._sequence = 0
        self._sent: deque[tuple[int, float]] = deque(maxlen=REMEMBERED)
        self._said: Order | None = None
        self._again_s = 0.0
        self._patience_ends_s = 0.0
        self._answers = False
        self._decoder = Decoder(NO_SESSION)
        self._report: ReportBody | None = None
        self._robot_time_ms = 0.0
        self._robot_s = 0.0  # the same, unwrapped, since its first report
        self._heard_s = 0.0

    def hello(self, now_s: float) -> bytes:
        self._session = _draw(self._session)
        self._decoder = Decoder(self._session)
        self._report = None
        self._cannot = False
        self._odometry.forget()
        self._answers = False
        self._sent.clear()
        self._patience_ends_s = now_s + SILENT_AFTER_S
        return self._greet(now_s)

    def data_to_send(self, order: Order, now_s: float) -> tuple[bytes, float]:
        if self._answers and self.overdue(now_s):
            return self.hello(now_s), self._again_s
        if now_s < self._again_s and (order == self._said or not self._answers):
            return b"", self._due_s()
        if not self._answers:
            return self._greet(now_s), self._again_s
        said, moves = self._said, not order.twist.is_zero
        # A starved process may have skipped the stop between two turns.
        begins_moving = moves and said is not None and order.turn > said.turn
        self._said = order
        self._again_s = now_s + (DRIVE_EVERY_S if moves else STOP_EVERY_S)
        words = self._frame(StopBody(), order.turn, now_s) if begins_moving else b""
        words += self._frame(self._motion(order), order.turn, now_s)
        for name, position in order.axes:
            axis = AxisBody(self._axes.index(name), round(position * POSITION_SCALE))
            words += self._frame(axis, order.turn, now_s)
        return words, self._due_s()

    def farewell(self) -> bytes:
        turn = 0 if self._said is None else self._said.turn
        return self._frame(StopBody(), turn, self._heard_s)

    def receive_data(self, data: bytes, now_s: float) -> None:
        for frame in self._decoder.feed(data):
            if isinstance(frame.body, ReportBody):
                self._take(frame.body, frame.time_ms, now_s)

    def answers(self, now_s: float) -> bool:
        return self._answers and not self.overdue(now_s)

    def overdue(self, now_s: float) -> bool:
        return now_s >= self._patience_ends_s

    def complaint(self, port: str) -> Sentence:
        return Sentence(
            "robot.not_sideways_on" if self._cannot else "robot.no_answer_on", {"port": port}
        )

    @property
    def reading(self) -> Reading:
        extra = {"line_errors": float(self._decoder.errors)}
        extra |= {f"{wheel}_mps": speed for wheel, speed in self._odometry.speeds.items()}
        report = self._report
        if report is None:
            return Reading(pose=self._odometry.pose, extra=extra)
        extra |= {
            "left_ticks": float(report.left_ticks),
            "right_ticks": float(report.right_ticks),
            "moving": float(report.moving),
            "timed_out": float(report.timed_out),
            "last_sequence": float(report.sequence),
            "robot_line_errors": float(report.damaged),
            "robot_refused": float(report.refused),
        }
        return Reading(
            moving=report.moving,
            pose=self._odometry.pose,
            bumpers=report.bumpers,
            battery_v=report.battery_mv / 1000.0 or None,  # 0: not measured
            extra=extra,
        )

    def _take(self, report: ReportBody, robot_time_ms: int, now_s: float) -> None:
        stopped_itself = self._answers and report.timed_out
        self._report = report
        self._robot_s += ((robot_time_ms - round(self._robot_time_ms)) % _CLOCK_WRAPS_MS) / 1000.0
        if not self._moves_sideways:
            self._odometry.take((report.left_ticks, report.right_ticks), self._robot_s)
        self._robot_time_ms, self._heard_s = float(robot_time_ms), now_s
        sent_s = max((at_s for number, at_s in self._sent if number == report.sequence), default=0)
        if now_s - sent_s >= SILENT_AFTER_S:
            return
        self._cannot = self._moves_sideways and not report.moves_sideways
        if self._cannot:
            self._patience_ends_s = now_s
            return
        self._patience_ends_s = now_s if stopped_itself else sent_s + SILENT_AFTER_S
        if not self._answers:
            self._answers = True
            self._decoder.errors = 0  # frames from before the session are no errors

    def _greet(self, now_s: float) -> bytes:
        self._said = None
        self._cannot = self._cannot and now_s - self._heard_s < SILENT_AFTER_S
        self._again_s = now_s + HELLO_EVERY_S
        return self._frame(HelloBody(self._session), 0, now_s) + self._frame(StopBody(), 0, now_s)

    def _due_s(self) -> float:
        return min(self._again_s, self._patience_ends_s) if self._answers else self._again_s

    def _motion(self, order: Order) -> Body:
        if order.twist.is_zero:
            return StopBody()
        if self._moves_sideways:
            twist = order.twist
            return MoveBody(
                round(twist.linear_mps * 1000.0),
                round(twist.lateral_mps * 1000.0),
                round(twist.angular_rps * 1000.0),
            )
        wheels = self._mixer.mix(order.twist)
        return DriveBody(round(wheels["left"] * 1000.0), round(wheels["right"] * 1000.0))

    def _frame(self, body: Body, turn: int, now_s: float) -> bytes:
        self._sequence = (self._sequence + 1) & 0xFFFF
        self._sent.append((self._sequence, now_s))
        known = self._report is not None and not isinstance(body, HelloBody)
        time_ms = self._robot_time_ms + (now_s - self._heard_s) * 1000.0 if known else 0.0
        ttl_ms = self._ttl_ms if isinstance(body, DriveBody | MoveBody | AxisBody) else 0
        frame = Frame(body, sequence=self._sequence, turn=turn, ttl_ms=ttl_ms, time_ms=int(time_ms))
        return encode(frame, self._session)


def _draw(last: int) -> int:
    """Draw a session that is not the last one."""
    session = 1 + secrets.randbelow(NO_SESSION - 2)
    return session if session != last else NO_SESSION - 1
