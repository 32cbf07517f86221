"""The watchdog of the driver process: which of the server's messages reach the driver (pure).

It does not trust the server, which may be late, frozen, gone or wrong. It passes only the newest
set-point of the newest turn, while that is fresh by the server's own timestamp. After a fault it
passes only standstill until the server has asked for standstill.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from wax.driver.checks import NO_ANSWER, within
from wax.driver.interface import STANDSTILL, Twist
from wax.robot.process.pipe_messages import Axis, Control, Halt, Move
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Iterable

    from wax.config.controls import ControlSettings
    from wax.driver.interface import ControlValue, Limits
    from wax.robot.process.pipe_messages import Message

COUNTS: Final = (
    "driver_silences",
    "driver_stale",
    "driver_repeated",
    "driver_old_turn",
    "driver_unarmed",
    "driver_garbage",
    "driver_failures",
)
SILENT: Final = Sentence("robot.server_silent")
GARBLED: Final = Sentence("robot.garbled")
NEUTRAL_FIRST: Final = Sentence("robot.held")


@dataclass(frozen=True, slots=True)
class Apply:
    """Call `Driver.apply`."""

    twist: Twist
    turn: int


@dataclass(frozen=True, slots=True)
class SetAxis:
    """Call `Driver.set_axis`."""

    name: str
    position: float
    turn: int


@dataclass(frozen=True, slots=True)
class SetControl:
    """Call `HasControls.control`; `moves` is false for a control that only lights or sounds."""

    name: str
    value: ControlValue
    turn: int
    moves: bool

    @property
    def is_release(self) -> bool:
        """Whether it releases a held control."""
        return self.value is None or self.value is False


@dataclass(frozen=True, slots=True)
class StopDriver:
    """Call `Driver.stop`."""

    turn: int


Call = Apply | SetAxis | SetControl | StopDriver


class DriverWatchdog:
    """Turns the server's messages, and its silence, into calls to the driver.

    - Silence means that the newest set-point or stop is `silence_s` old by its timestamp, or that
      the server has not stopped the robot when its command expired (`Move.end_s`). It causes a
      *hold*, which stops the robot, as do an invalid message, a driver that raises, and a robot
      that has reconnected.
    - After a hold, and at the start of each turn, nothing moves, axes included, until a set-point
      of standstill arrives with a timestamp later than the hold. A turn begins with a stop.
    - A held control is released at a hold and between two turns; one that moves is also released at
      a stop. One that moves may start only when an axis may; a release is never refused.
    - A set-point or axis position that is older than `silence_s`, past its end, out of sequence, or
      of a lower turn is refused, and does not end the silence. A stop is never refused.

    `problem` says why the robot is held, None while it is not; `holds` counts the holds.
    """

    def __init__(
        self, limits: Limits, silence_s: float, controls: Iterable[ControlSettings] = ()
    ) -> None:
        self.limits = limits
        self._controls = {one.name: one for one in controls}
        self._held: dict[str, ControlValue] = {}
        self._silence_s = silence_s
        self._turn = 0
        self._sequence = -1
        self._newest_s = -math.inf
        self._held_s = -math.inf
        self._armed = False
        self._twist = STANDSTILL
        self.silent_at_s = math.inf
        """When silence will stop the robot; infinite before the first message."""
        self.problem: Sentence | None = None
        self.holds = 0
        self.counts = dict.fromkeys(COUNTS, 0)

    @property
    def turn(self) -> int:
        """The newest turn's number."""
        return self._turn

    def handle(self, message: Message, now_s: float) -> tuple[Call, ...]:
        """Handle a message; check silence first, so that a queued message cannot hide it."""
        calls = self.tick(now_s)
        if isinstance(message, Halt):
            return (*calls, *self._halt(message, now_s))
        if isinstance(message, Control) and message.name in self._held and _lets_go(message):
            return (*calls, *self._let_go(message.name))
        refusal = self._refusal(message, now_s)
        if refusal is not None:
            self.counts[refusal] += 1
            return calls
        self._sequence = message.sequence
        calls = (*calls, *self._begin(message.turn))
        if isinstance(message, Axis):
            return (*calls, *self._axis(message))
        if isinstance(message, Control):
            return (*calls, *self._control(message))
        return (*calls, self._move(message))

    def repeat(self, now_s: float) -> tuple[Call, ...]:
        """Repeat the current set-point."""
        return (*self.tick(now_s), Apply(self._twist, self._turn))

    def tick(self, now_s: float) -> tuple[Call, ...]:
        """Stop the robot if the server has been silent for too long."""
        if now_s < self.silent_at_s:
            return ()
        self.counts["driver_silences"] += 1
        return self.hold(SILENT, now_s)

    def handle_invalid(self, now_s: float) -> tuple[Call, ...]:
        """Hold the robot because of an invalid message."""
        self.counts["driver_garbage"] += 1
        return self.hold(GARBLED, now_s)

    def failed(self, now_s: float) -> tuple[Call, ...]:
        """Hold the robot because the driver raised."""
        self.counts["driver_failures"] += 1
        return self.hold(NO_ANSWER, now_s)

    def hold(self, problem: Sentence | None, now_s: float) -> tuple[Call, ...]:
        """Stop the robot; nothing sent before `now_s` moves it again."""
        self._disarm()
        self._held_s = now_s
        self.silent_at_s = math.inf
        self.problem = problem
        self.holds += 1
        return (StopDriver(self._turn), *self._let_go(*self._held))

    def _halt(self, halt: Halt, now_s: float) -> tuple[Call, ...]:
        self._sequence = max(self._sequence, halt.sequence)
        released = self._begin(halt.turn)[1:]
        self._twist = STANDSTILL
        if self._is_fresh(halt, now_s):
            self._heard(halt)
        moving = [name for name in self._held if self._controls[name].moves]
        return (StopDriver(self._turn), *released, *self._let_go(*moving))

    def _move(self, move: Move) -> Call:
        self._heard(move)
        asked = Twist(move.linear_mps, move.angular_rps, move.lateral_mps)
        if asked.is_zero and move.sent_s > self._held_s:
            self._armed, self.problem = True, None
        self._twist = within(asked, self.limits) if self._armed else STANDSTILL
        if not self._armed and not asked.is_zero:
            self._wait_for_neutral()
        return Apply(self._twist, self._turn)

    def _axis(self, axis: Axis) -> tuple[Call, ...]:
        if not self._armed:
            self._wait_for_neutral()
            return ()
        if axis.name not in self.limits.axes:
            return ()
        return (SetAxis(axis.name, axis.position, self._turn),)

    def _control(self, message: Control) -> tuple[Call, ...]:
        control = self._controls.get(message.name)
        if control is None:
            return ()
        is_release = control.is_held and _lets_go(message)
        if control.moves and not self._armed and not is_release:
            self._wait_for_neutral()
            return ()
        if control.is_held and not is_release:
            self._held[message.name] = message.value
        return (SetControl(message.name, message.value, self._turn, control.moves),)

    def _let_go(self, *names: str) -> tuple[SetControl, ...]:
        """Release controls that are held."""
        released = []
        for name in names:
            value = False if isinstance(self._held.pop(name), bool) else None
            released.append(SetControl(name, value, self._turn, self._controls[name].moves))
        return tuple(released)

    def _wait_for_neutral(self) -> None:
        self.counts["driver_unarmed"] += 1
        self.problem = self.problem or NEUTRAL_FIRST

    def _begin(self, turn: int) -> tuple[Call, ...]:
        """Stop between two turns; nothing of the old turn carries over."""
        if turn <= self._turn:
            return ()
        self._turn = turn
        self._disarm()
        return (StopDriver(turn), *self._let_go(*self._held))

    def _disarm(self) -> None:
        self._armed = False
        self._twist = STANDSTILL

    def _refusal(self, message: Move | Axis | Control, now_s: float) -> str | None:
        end_s = message.end_s if isinstance(message, Move) else None
        is_over = end_s is not None and now_s >= end_s
        if is_over or not self._is_fresh(message, now_s):
            return "driver_stale"
        if message.sequence <= self._sequence:
            return "driver_repeated"
        if message.turn < self._turn:
            return "driver_old_turn"
        return None

    def _is_fresh(self, message: Message, now_s: float) -> bool:
        """Judge by the sender's timestamp; a future one is not from this machine's clock."""
        return 0.0 <= now_s - message.sent_s < self._silence_s

    def _heard(self, message: Move | Halt) -> None:
        self._newest_s = max(self._newest_s, message.sent_s)
        self.silent_at_s = self._newest_s + self._silence_s
        if isinstance(message, Move) and message.end_s is not None:
            self.silent_at_s = min(self.silent_at_s, message.end_s)


def _lets_go(message: Control) -> bool:
    return message.value is None or message.value is False
