"""Lines from a board that the host describes: only proper answers let the robot move."""

from __future__ import annotations

import math
from typing import Final

from tests.fuzz.target import Target

from wax.config.robot import RobotSettings
from wax.driver.interface import Limits, Twist
from wax.robot.line.setpoints import Order
from wax.robot.serial.text_dialect import TextDialect
from wax.robot.wheels import WheelMixer

_PIECE: Final = 7
_ANSWER_S: Final = 0.5
_SETTINGS: Final = RobotSettings.model_validate(
    {
        "serial": {
            "dialect": "text",
            "ticks_per_m": 1000.0,
            "text": {
                "drive": "m {left} {right}\r",
                "per_mps": 1000.0,
                "boot_ms": 0,
                "answers": "OK",
                "reports": [
                    "{left_ticks} {right_ticks}",
                    "V={battery_v}:{_}",
                    "B{bumpers}",
                    "S{left},{right}",
                ],
            },
        }
    }
)
_STOP: Final = b"m 0 0"


def _hear(data: bytes) -> None:
    """Let a board send anything; a motion is only reported while it answers."""
    dialect = TextDialect(_SETTINGS, WheelMixer(_SETTINGS), Limits(0.6, 1.5))
    order = Order(Twist(0.5, 0.0), 1)
    now_s = 100.0
    dialect.hello(now_s)
    for at in range(0, len(data), _PIECE):
        now_s += 0.02
        dialect.receive_data(data[at : at + _PIECE], now_s)
        answers = dialect.answers(now_s)
        said, due_s = dialect.data_to_send(order, now_s)
        assert due_s > now_s, "it would be asked without a pause"
        assert answers or set(said.split(b"\r")) <= {b"", _STOP}, f"unanswered it said {said!r}"
        assert not answers or b"OK" in data, "it took something else for an answer"
        reading = dialect.reading
        assert reading.moving in (None, True, False)
        assert 0 <= reading.bumpers <= 0xFF
        assert reading.battery_v is None or math.isfinite(reading.battery_v)
        assert reading.pose is None or math.isfinite(reading.pose.x_m + reading.pose.y_m)
        assert all(math.isfinite(value) for value in reading.extra.values())
        assert str(dialect.complaint("/dev/x")).isprintable()
    assert not dialect.answers(now_s + _ANSWER_S)


TEXT: Final = Target(
    name="text",
    what="lines of a board, in the server",
    hear=_hear,
    seeds=(
        b"OK\r\nOK\r\nOK\r\n1 2\r\n3 4\r\nV=12.5:3\r\n",
        b"OK\rB3\rS-10,+20.5\rInvalid Command\r",
        b"Ready\r\n" * 4 + b"OK\n" * 20,
    ),
    words=(b"OK\r", b"\r", b"\n", b"-", b".", b"9" * 12, b" ", b"V=", b"\xff", b"x" * 128),
    max_bytes=600,
    steps=200_000,  # the most that lines of a few bytes cost
)
