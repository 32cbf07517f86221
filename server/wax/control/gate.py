"""The gate: which commands count, and what the robot is told because of them. Pure.

A command counts if it comes from this turn's operator, who is not lost, carries the turn's
number, holds only numbers in range, follows every earlier one by its sequence number and is
fresh. Whatever is wrong, the answer is standstill and a sentence that says why.

Nothing moves at the start of a turn, after a stop and after a fault until a *neutral* command
(no motion asked for) was seen that was sent after that moment: a key held down through it must
be released and pressed anew. What was sent before that moment never moves the robot again.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import TYPE_CHECKING, Literal

from wax.control.freshness import is_from_future, is_too_old
from wax.robot.driver import STANDSTILL, Twist

if TYPE_CHECKING:
    from collections.abc import Mapping

    from wax.config import DriveSettings
    from wax.robot.driver import Limits

NOBODY_DRIVES = "Nobody is driving."


class Refusal(Enum):
    """Why a command does not count; the value is the sentence for its sender."""

    NOT_YOUR_TURN = "It is not your turn."
    LOST = "Your connection is lost; the robot waits for you."
    OTHER_TURN = "This command belongs to another turn."
    OUT_OF_RANGE = "A command held a number that is out of range."
    OUT_OF_ORDER = "A newer command has arrived already."
    TOO_OLD = "No fresh command: the link is late."
    FROM_FUTURE = "Your clock and the robot's are not aligned yet."


class Hold(Enum):
    """Why a neutral command must come first; the value is the sentence for the operator."""

    TURN_STARTED = "Your turn has begun: let go of all controls once, then drive."
    STOPPED = "Stopped: let go of all controls, then drive again."
    LOST = "Your connection was lost: let go of all controls, then drive again."
    FAULT = "The robot was not ready: let go of all controls, then drive again."
    LATE = "The server was late and stopped the robot: let go of all controls, then drive again."


@dataclass(frozen=True, slots=True)
class Command:
    """A complete set-point of the operator's hands.

    `linear` and `angular` are shares of the limits in -1…1 (ahead and left are positive),
    `axes` positions in -1…1. `sent_s` and `seen_s` (the capture time of the newest presented
    picture) are on the server's clock.
    """

    seq: int
    turn: int
    sent_s: float
    linear: float
    angular: float
    speed: Literal["fine", "gross"]
    seen_s: float | None = None
    axes: Mapping[str, float] = field(default_factory=dict)

    @property
    def is_neutral(self) -> bool:
        """No motion is asked for; axes are positions and keep theirs."""
        return self.linear == 0 and self.angular == 0

    @property
    def is_in_range(self) -> bool:
        """Every number is finite and within its bounds."""
        shares = (self.linear, self.angular, *self.axes.values())
        return math.isfinite(self.sent_s) and all(-1 <= share <= 1 for share in shares)


@dataclass(frozen=True, slots=True)
class TurnView:
    """What the gate knows of the turn. `one_way_s` was measured at its start; None if unknown."""

    number: int
    operator: int | None
    present: bool
    one_way_s: float | None


@dataclass(frozen=True, slots=True)
class GateState:
    """What the gate remembers within the turn with this number.

    `command` is the newest that counted, its `sent_s` never later than its arrival, never
    earlier than `hold_since_s`. While it is None only a neutral one is taken; `hold` says why.
    `refused` is why the operator's newest command did not count, None after one that did.
    """

    turn: int = 0
    newest_seq: int | None = None
    command: Command | None = None
    refused: Refusal | None = None
    hold: Hold = Hold.TURN_STARTED
    hold_since_s: float = math.inf


@dataclass(frozen=True, slots=True)
class Setpoint:
    """What the robot is told. `reason` is a sentence while the gate keeps it standing, else None.

    `axes` holds only axes that the robot has; one that is not named keeps its position.
    """

    twist: Twist = STANDSTILL
    axes: Mapping[str, float] = field(default_factory=dict)
    reason: str | None = None


def begin(turn: int, now_s: float) -> GateState:
    """Make the state at the start of a turn, or of a new connection of its operator's."""
    return GateState(turn=turn, hold_since_s=now_s)


def require_neutral(state: GateState, now_s: float, why: Hold) -> GateState:
    """Forget the command; nothing moves until a neutral one that is sent after `now_s`."""
    return replace(state, command=None, hold=why, hold_since_s=now_s)


def accept(
    state: GateState,
    viewer: int,
    command: Command,
    *,
    turn: TurnView,
    now_s: float,
    settings: DriveSettings,
) -> tuple[GateState, Refusal | None]:
    """Take a command that has just arrived, or say why not; a refused one moves nothing."""
    refusal = _foreign(state, viewer, command, turn)
    if refusal is not None:
        return state, refusal
    refusal = _unusable(command, turn, now_s, settings)
    if refusal is not None:
        return replace(state, refused=refusal), refusal
    # A stamp ahead of us must not make the command last longer.
    command = replace(command, sent_s=min(command.sent_s, now_s))
    state = replace(state, newest_seq=command.seq, refused=None)
    moves_on = state.command is not None or command.is_neutral
    if moves_on and command.sent_s >= state.hold_since_s:
        state = replace(state, command=command)
    return state, None


def decide(
    state: GateState, turn: TurnView, now_s: float, settings: DriveSettings, limits: Limits
) -> Setpoint:
    """Say what the robot is told now: within `limits`, whatever the command says."""
    if turn.operator is None:
        return Setpoint(reason=NOBODY_DRIVES)
    if not turn.present:
        return Setpoint(reason=Refusal.LOST.value)
    if state.turn != turn.number:
        return Setpoint(reason=Hold.TURN_STARTED.value)
    command = state.command
    if command is None:
        return Setpoint(reason=(state.refused or state.hold).value)
    if _is_stale(command, turn, now_s, settings):
        return Setpoint(reason=(state.refused or Refusal.TOO_OLD).value)
    fraction = settings.fine_fraction if command.speed == "fine" else 1.0
    return Setpoint(
        twist=Twist(
            linear_mps=_clamp(command.linear * fraction) * limits.linear_mps,
            angular_rps=_clamp(command.angular * fraction) * limits.angular_rps,
        ),
        axes={name: _clamp(command.axes[name]) for name in limits.axes if name in command.axes},
    )


def _foreign(state: GateState, viewer: int, command: Command, turn: TurnView) -> Refusal | None:
    """Refuse what is not the next word of this turn's operator."""
    if turn.operator is None or viewer != turn.operator:
        return Refusal.NOT_YOUR_TURN
    if not turn.present:
        return Refusal.LOST
    if not command.turn == turn.number == state.turn:
        return Refusal.OTHER_TURN
    if state.newest_seq is not None and command.seq <= state.newest_seq:
        return Refusal.OUT_OF_ORDER
    return None


def _unusable(
    command: Command, turn: TurnView, now_s: float, settings: DriveSettings
) -> Refusal | None:
    """Refuse what must not move the robot, whoever says it."""
    if not command.is_in_range:
        return Refusal.OUT_OF_RANGE
    if _is_stale(command, turn, now_s, settings):
        return Refusal.TOO_OLD
    if is_from_future(command.sent_s, now_s, one_way_s=turn.one_way_s):
        return Refusal.FROM_FUTURE
    return None


def _is_stale(command: Command, turn: TurnView, now_s: float, settings: DriveSettings) -> bool:
    max_age_s = settings.max_age_ms / 1000
    return is_too_old(command.sent_s, now_s, max_age_s=max_age_s, one_way_s=turn.one_way_s)


def _clamp(share: float) -> float:
    return max(-1.0, min(1.0, share))
