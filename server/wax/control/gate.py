"""The gate: which commands count, and what the robot is told because of them. Pure.

A command counts if it comes from this turn's operator, who is not lost, carries the turn's
number, holds only numbers in range, follows every earlier one by its sequence number and is
fresh. Whatever is wrong, the answer is standstill and a sentence that says why.

Nothing moves at the start of a turn, after a stop and after a fault until a *neutral* command
(all let go) was seen that was sent after that moment, by somebody who sees: a key held down
through it must be released and pressed anew. What was sent before that moment never moves the
robot again. Where the commands or the picture lapse for a moment (`LAPSE_S`) driving goes on by
itself when they are back; after a longer lapse neutral comes first, as after a fault.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

from wax.control import speed, video_freshness
from wax.control.command import Command
from wax.control.command_freshness import is_from_future, is_too_old, time_to_live_s
from wax.control.reasons import (
    NO_LIMITS,
    NOBODY_DRIVES,
    NOT_HELD,
    Hold,
    Limit,
    Refusal,
    stopped_by,
)
from wax.control.turn_view import TurnView
from wax.control.video_freshness import VideoFreshness
from wax.driver.interface import STANDSTILL, Twist

if TYPE_CHECKING:
    from collections.abc import Mapping

    from wax.control.rules import Rules
    from wax.control.stop_latch import LatchedStop
    from wax.driver.interface import Limits

__all__ = ["Command", "GateState", "Hold", "Limit", "Refusal", "Setpoint", "TurnView"]

LAPSE_S: Final = 1.0
"""A hand that was steady for so long is still there; after more it must say so anew."""


@dataclass(frozen=True, slots=True)
class GateState:
    """What the gate remembers within the turn with this number.

    `command` is the newest that counted, its `sent_s` never later than its arrival, never
    earlier than `hold_since_s`. While it is None only a neutral one is taken; `hold` says why.
    `refused` is why the operator's newest command did not count, None after one that did.
    `well_s` is when a command was last fresh and its sender saw.
    """

    turn: int = 0
    newest_seq: int | None = None
    command: Command | None = None
    refused: Refusal | None = None
    hold: Hold = Hold.TURN_STARTED
    hold_since_s: float = math.inf
    well_s: float = -math.inf


@dataclass(frozen=True, slots=True)
class Setpoint:
    """What the robot is told.

    `reason` is a sentence while the gate keeps it standing, `limit` one while it is slower than its
    operator wants, else None. `soft` says that motion may end at the braking rate, where the robot
    is so configured. `axes` holds only axes that the robot has; one not named keeps its position.
    """

    twist: Twist = STANDSTILL
    axes: Mapping[str, float] = field(default_factory=dict)
    reason: str | None = None
    limit: str | None = None
    soft: bool = False


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
    rules: Rules,
) -> tuple[GateState, Refusal | None]:
    """Take a command that has just arrived, or say why not; a refused one moves nothing."""
    refusal = _foreign(state, viewer, command, turn)
    if refusal is not None:
        return state, refusal
    # Stamps ahead of us must not make the command, or what its sender sees, last longer.
    seen_s = video_freshness.believed_s(command.seen_s, now_s, turn.one_way_s)
    refusal = _unusable(command, turn, now_s, rules) or _unseeing(state, seen_s, turn, now_s, rules)
    if refusal is not None:
        return replace(state, refused=refusal), refusal
    command = replace(command, sent_s=min(command.sent_s, now_s), seen_s=seen_s)
    state = replace(state, newest_seq=command.seq, refused=None)
    if command.sent_s < state.hold_since_s:
        return state, None
    if state.command is None:
        if not command.is_neutral:
            return state, None
        state = replace(state, well_s=now_s)
    return replace(state, command=command), None


def decide(
    state: GateState, turn: TurnView, stop: LatchedStop | None, now_s: float, rules: Rules
) -> tuple[GateState, Setpoint]:
    """Say what the robot is told now: within the limits, whatever the command says.

    To be asked at every beat: the state that comes back knows since when something lapses.
    """
    if stop is not None:
        state = require_neutral(state, now_s, Hold.STOPPED)
        return state, Setpoint(reason=stopped_by(stop.by))
    ttl_s = time_to_live_s(turn.one_way_s, rules)
    if turn.operator is None or not turn.present or state.turn != turn.number or ttl_s is None:
        return state, Setpoint(reason=_no_way(state, turn))
    command = state.command
    if command is None:
        return state, _held_back(state)
    seen = video_freshness.judge(command.seen_s, now_s, turn, rules)
    lapse = _lapse(command, seen, now_s, ttl_s)
    if now_s - state.well_s > LAPSE_S:
        state = require_neutral(state, now_s, Hold.LAPSED)
        return state, _held_back(state)
    if lapse is not None:
        return state, Setpoint(reason=(state.refused or lapse).value, soft=True)
    return replace(state, well_s=now_s), _driven(command, seen, ttl_s, rules)


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


def _unusable(command: Command, turn: TurnView, now_s: float, rules: Rules) -> Refusal | None:
    """Refuse what must not move the robot, whoever says it."""
    if not command.is_in_range:
        return Refusal.OUT_OF_RANGE
    ttl_s = time_to_live_s(turn.one_way_s, rules)
    if ttl_s is None:
        return Refusal.TOO_SLOW
    if is_too_old(command.sent_s, now_s, ttl_s):
        return Refusal.TOO_OLD
    if is_from_future(command.sent_s, now_s, one_way_s=turn.one_way_s):
        return Refusal.FROM_FUTURE
    return None


def _unseeing(
    state: GateState, seen_s: float | None, turn: TurnView, now_s: float, rules: Rules
) -> Refusal | None:
    """Refuse what would begin to drive blindly: who sees nothing has not let go of this picture."""
    is_blind = video_freshness.judge(seen_s, now_s, turn, rules) is VideoFreshness.NONE
    return Refusal.BLIND if is_blind and state.command is None else None


def _no_way(state: GateState, turn: TurnView) -> str:
    """Say why nobody's command may move the robot, whatever it is."""
    if turn.operator is None:
        return NOBODY_DRIVES
    if not turn.present:
        return Refusal.LOST.value
    return Hold.TURN_STARTED.value if state.turn != turn.number else Refusal.TOO_SLOW.value


def _held_back(state: GateState) -> Setpoint:
    """Stand until all is let go of."""
    return Setpoint(reason=(state.refused or state.hold).value, soft=state.hold is Hold.LAPSED)


def _lapse(command: Command, seen: VideoFreshness, now_s: float, ttl_s: float) -> Refusal | None:
    """Say what is missing at this moment, and may be back in the next."""
    if is_too_old(command.sent_s, now_s, ttl_s):
        return Refusal.TOO_OLD
    return Refusal.BLIND if seen is VideoFreshness.NONE else None


def _driven(command: Command, seen: VideoFreshness, ttl_s: float, rules: Rules) -> Setpoint:
    """Do what a command says that has passed; without the dead-man not even an axis moves."""
    if not command.held:
        return Setpoint(reason=NOT_HELD if command.asks_for_motion else None, soft=True)
    limits = rules.limits
    axes = {name: command.axes[name] for name in limits.axes if name in command.axes}
    twist, limit = speed.twist(command, seen, ttl_s, rules)
    if not _is_within(twist, limits):
        return Setpoint(reason=NO_LIMITS)
    return Setpoint(twist, axes, limit=None if limit is None else limit.value, soft=True)


def _is_within(twist: Twist, limits: Limits) -> bool:
    """Look once more, at what comes out: also a number of the robot's own may be none."""
    return (
        abs(twist.linear_mps) <= limits.linear_mps < math.inf
        and abs(twist.angular_rps) <= limits.angular_rps < math.inf
    )
