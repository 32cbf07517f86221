"""The line of a hand control aboard, with the rules that interpret it.

Anybody may write on the line, so the person may seem to drive, but only by a reading that our own
decoder found, and after one at rest.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from tests.fuzz.target import Target

from wax.config.local import LocalSettings
from wax.config.robot import RobotSettings
from wax.control import local_hand
from wax.control.local_hand import HandRules, HandState
from wax.driver.hand import HandReading
from wax.driver.interface import STANDSTILL, Limits
from wax.robot.hand.line import ASIDE, START, HandDecoder, encode

if TYPE_CHECKING:
    from collections.abc import Iterable

_LIMITS: Final = Limits(linear_mps=0.6, angular_rps=1.5, lateral_mps=0.6)
_RULES: Final = HandRules.of(LocalSettings(source="serial"), RobotSettings(), 0.02)
_PIECE: Final = 5
_BEGAN_S: Final = 100.0


def _hear(data: bytes) -> None:
    pieces = [data[at : at + _PIECE] for at in range(0, len(data), _PIECE)]
    decoder, state, rested = HandDecoder(), HandState(), False
    found: list[HandReading] = []
    now_s = _BEGAN_S
    for piece in pieces:
        now_s += 0.001
        for reading in decoder.feed(piece, now_s):
            found.append(reading)
            rested = rested or not local_hand.touches(reading, _RULES)
            state = local_hand.accept(state, reading, now_s, _RULES)
            twist = local_hand.twist(state, _RULES, _LIMITS)
            assert rested or twist == STANDSTILL, "a control drives that was never at rest"
            assert twist.speed_mps <= _LIMITS.linear_mps + 1e-9
            assert abs(twist.angular_rps) <= _LIMITS.angular_rps
            assert reading.is_in_range or state.mode == "lost", f"{reading} was taken for one"
    assert _as_said(HandDecoder().feed(data, now_s)) == _as_said(found), (
        "pieces make other readings"
    )
    assert local_hand.tick(state, now_s + 1.0, _RULES).mode == "lost"


def _as_said(readings: Iterable[HandReading]) -> list[tuple[object, ...]]:
    return [(r.linear, r.angular, r.lateral, r.is_held, r.stop, r.ask) for r in readings]


def _frame(number: int, linear: float = 0.0, *, stop: bool = False, held: bool = False) -> bytes:
    return encode(HandReading(0.0, linear, is_held=held, stop=stop), number)


_ASIDE: Final = encode(HandReading(0.0, lateral=1.0), 2, has_aside=True)

HAND: Final = Target(
    name="hand",
    what="frames of a hand control",
    hear=_hear,
    seeds=(
        _frame(1) + _frame(2, 1.0) + _frame(3, -1.0),
        _frame(1) + _frame(2, stop=True) + encode(HandReading(0.0, ask="go_on"), 3),
        _frame(1, held=True) + _frame(2, 1.27) + _frame(3),
        START * 3 + _frame(1),
        _frame(1)
        + _ASIDE
        + _frame(3)
        + encode(HandReading(0.0, 0.5, lateral=-1.0), 4, has_aside=True),
    ),
    words=(START, START[:1], ASIDE, _ASIDE, _frame(4), _frame(5, 1.0), _frame(6, stop=True)),
    max_bytes=300,
)
