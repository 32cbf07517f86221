"""Speak the dialect ``bytes``: one byte a command, sent only on change (thesis 6.3.3; pure).

A twist becomes one of eight directions by the sector it lies in, and one of two speeds: *gross*
above half of the limit, else *fine*. Left means a left turn both forward and backward. The byte of
a new speed precedes the direction, which is then sent again.

Such boards have no time-to-live: they follow the last command for ever. Because losing the stop
byte would leave the robot moving, it is sent three times, 20 ms apart. No software can stop such a
board once its cable is pulled: give it a watchdog, or use the dialect ``frames``.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from wax.driver.interface import Reading
from wax.sentence import Sentence

if TYPE_CHECKING:
    from wax.config.serial import BytesDialectSettings
    from wax.driver.interface import Limits, Twist
    from wax.robot.line.setpoints import Order

STOP_TIMES: Final = 3
STOP_GAP_S: Final = 0.02
GROSS_ABOVE: Final = 0.5
DEAD_ZONE: Final = 0.05
"""A smaller share of the limits counts as standstill."""


class BytesDialect:
    """A `Dialect` for existing boards."""

    def __init__(self, table: BytesDialectSettings, limits: Limits) -> None:
        self._limits = limits
        self._stop = table.stop
        self._fine, self._gross = table.fine, table.gross
        # Counter-clockwise in steps of 45 degrees, beginning straight ahead.
        self._ahead_round = (
            table.forward,
            table.forward_left,
            table.left,
            table.back_left,
            table.back,
            table.back_right,
            table.right,
            table.forward_right,
        )
        self._said: tuple[int | None, int] | None = None
        self._turn = 0
        self._stops_left = 0
        self._stop_again_s = 0.0

    def hello(self, now_s: float) -> bytes:
        self._said = (None, self._stop)
        return self._first_stop(now_s)

    def data_to_send(self, order: Order, now_s: float) -> tuple[bytes, float]:
        wanted = self._command(order.twist)
        is_new_turn, self._turn = order.turn > self._turn, order.turn
        if is_new_turn and self._moves(self._said) and self._moves(wanted):
            # A starved process may have skipped the stop between two turns.
            words, due_s = self._say_new(*wanted, now_s)
            return bytes([self._stop]) + words, due_s
        if wanted != self._said:
            return self._say_new(*wanted, now_s)
        if self._stops_left == 0:
            return b"", math.inf
        if now_s < self._stop_again_s:
            return b"", self._stop_again_s
        self._stops_left -= 1
        self._stop_again_s = now_s + STOP_GAP_S
        return bytes([self._stop]), self._stop_again_s if self._stops_left else math.inf

    def farewell(self) -> bytes:
        return bytes([self._stop] * STOP_TIMES)

    def receive_data(self, data: bytes, now_s: float) -> None:
        """Ignore the data: such boards report nothing."""

    def answers(self, _now_s: float, /) -> bool:
        return True

    def overdue(self, _now_s: float, /) -> bool:
        return False

    def complaint(self, port: str) -> Sentence:
        return Sentence("robot.no_answer_on", {"port": port})

    @property
    def reading(self) -> Reading:
        return Reading()

    def _moves(self, said: tuple[int | None, int] | None) -> bool:
        return said is not None and said[1] != self._stop

    def _say_new(self, speed: int | None, direction: int, now_s: float) -> tuple[bytes, float]:
        speed_before = None if self._said is None else self._said[0]
        self._said = (speed, direction)
        if direction == self._stop:
            return self._first_stop(now_s), self._stop_again_s
        self._stops_left = 0
        if speed is None or speed == speed_before:
            return bytes([direction]), math.inf
        return bytes([speed, direction]), math.inf

    def _first_stop(self, now_s: float) -> bytes:
        self._stops_left = STOP_TIMES - 1
        self._stop_again_s = now_s + STOP_GAP_S
        return bytes([self._stop])

    def _command(self, twist: Twist) -> tuple[int | None, int]:
        ahead = twist.linear_mps / self._limits.linear_mps
        left = twist.angular_rps / self._limits.angular_rps
        size = max(abs(ahead), abs(left))
        speed_before = None if self._said is None else self._said[0]
        if size < DEAD_ZONE:
            return speed_before, self._stop
        sector = round(math.atan2(left, ahead) / (math.pi / 4.0)) % 8
        return self._gross if size > GROSS_ABOVE else self._fine, self._ahead_round[sector]
