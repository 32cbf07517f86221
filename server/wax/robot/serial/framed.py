"""Speak the dialect ``frames``: each change at once, and all again four times a time-to-live."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.robot.serial.frames import (
    POSITION_SCALE,
    Axis,
    Body,
    Decoder,
    Drive,
    Frame,
    Hello,
    Report,
    Stop,
    encode,
)

if TYPE_CHECKING:
    from wax.robot.serial.setpoints import Order
    from wax.robot.serial.wheels import Mixer

REPEATS_PER_TTL: Final = 4


class FramedDialect:
    """A `Dialect` for boards with a watchdog of their own: three frames in a row may be lost."""

    def __init__(self, mixer: Mixer, ttl_ms: int, axes: tuple[str, ...]) -> None:
        self._mixer = mixer
        self._axes = axes
        self._ttl_ms = ttl_ms
        self._sequence = 0
        self._said: Order | None = None
        self._repeat_s = 0.0
        self._decoder = Decoder()
        self._report: Report | None = None

    def hello(self, now_s: float) -> bytes:
        self._said = None
        self._repeat_s = now_s
        self._decoder = Decoder()
        self._report = None
        return self._frame(Hello(), 0) + self._frame(Stop(), 0)

    def say(self, order: Order, now_s: float) -> tuple[bytes, float]:
        if order == self._said and now_s < self._repeat_s:
            return b"", self._repeat_s
        self._said = order
        self._repeat_s = now_s + self._ttl_ms / 1000.0 / REPEATS_PER_TTL
        words = self._frame(self._motion(order), order.turn)
        for name, position in order.axes:
            axis = Axis(self._axes.index(name), round(position * POSITION_SCALE))
            words += self._frame(axis, order.turn)
        return words, self._repeat_s

    def farewell(self) -> bytes:
        turn = 0 if self._said is None else self._said.turn
        return self._frame(Stop(), turn)

    def hear(self, data: bytes) -> None:
        for frame in self._decoder.feed(data):
            if isinstance(frame.body, Report):
                self._report = frame.body

    def known(self) -> dict[str, float]:
        known = {"line_errors": float(self._decoder.errors)}
        report = self._report
        if report is not None:
            known |= {
                "battery_v": report.battery_mv / 1000.0,
                "bumpers": float(report.bumpers),
                "left_ticks": float(report.left_ticks),
                "right_ticks": float(report.right_ticks),
                "moving": float(report.moving),
                "timed_out": float(report.timed_out),
                "last_sequence": float(report.sequence),
            }
        return known

    def _motion(self, order: Order) -> Body:
        if order.twist.is_zero:
            return Stop()
        wheels = self._mixer.mix(order.twist)
        return Drive(round(wheels.left_mps * 1000.0), round(wheels.right_mps * 1000.0))

    def _frame(self, body: Body, turn: int) -> bytes:
        self._sequence = (self._sequence + 1) & 0xFFFF
        ttl_ms = self._ttl_ms if isinstance(body, Drive) else 0
        return encode(Frame(body, sequence=self._sequence, turn=turn, ttl_ms=ttl_ms))
