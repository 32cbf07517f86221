"""The gate: which commands count, and the set-point that follows from them. Pure.

A command counts if it comes from this turn's operator, who is connected, carries the turn's
number, holds only numbers in range, has a higher sequence number than every earlier one and is
fresh. Otherwise the robot stands still and a sentence says why.

At the start of a turn, after a stop and after a fault, nothing moves until a *neutral* command
(everything released) arrives that was sent after that moment by an operator with a fresh picture.
README.md draws these states. On another network (`session/room.py`), and while the person aboard
does not leave the robot to the operator, neutral must come first as well.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

from wax.control import speed, video_freshness
from wax.control.command import Command
from wax.control.command_freshness import (
    credible_sent_s,
    is_from_future,
    is_too_old,
    time_to_live_s,
)
from wax.control.reasons import (
    ABOARD,
    NO_LIMITS,
    NOBODY_DRIVES,
    NOT_HELD,
    NOT_LET,
    Hold,
    Limit,
    Refusal,
    stopped_by,
)
from wax.control.turn_view import TurnView
from wax.control.video_freshness import VideoFreshness
from wax.driver.checks import share_of
from wax.driver.interface import STANDSTILL, Twist

if TYPE_CHECKING:
    from collections.abc import Mapping

    from wax.control.rules import Rules
    from wax.control.stop_latch import LatchedStop
    from wax.driver.interface import Limits
    from wax.sentence import Sentence

__all__ = ["Command", "GateState", "Hold", "Limit", "Refusal", "Setpoint", "TurnView"]

LAPSE_S: Final = 1.0
"""A control held through an interruption this short still counts; after a longer one it must be
released and pressed again."""

_ROUNDING: Final = 1e-9
"""A vector's length may exceed its limit by this fraction."""


@dataclass(frozen=True, slots=True)
class GateState:
    """The gate's state within the turn with this number.

    `command` is the newest that counted; its `sent_s` is never later than its arrival or than is
    credible, never earlier than `hold_since_s`. While `command` is None only a neutral command
    takes its place; `hold` says why. `refused` is why the operator's newest command did not count,
    None after one that did. `well_s` is when command and picture were last both fresh; `lapsed`
    says that one of them is stale now.
    """

    turn: int = 0
    newest_seq: int | None = None
    command: Command | None = None
    refused: Refusal | None = None
    hold: Hold = Hold.TURN_STARTED
    hold_since_s: float = math.inf
    well_s: float = -math.inf
    lapsed: bool = False


@dataclass(frozen=True, slots=True)
class Setpoint:
    """The set-point for the robot.

    `reason` says why the gate holds the robot, `limit` why the robot is slower than its operator
    asks; each is None if not. `soft` allows motion to end at the braking rate, where the robot is
    configured for it: when the operator lets go, or commands or picture lapse; never at a Stop or
    fault. `axes` holds only axes that the robot has; others keep their position. `holds` says that
    the dead-man is held and all is well, so that other moving controls may move, too
    (`wax.control.controls`). `valid_until_s` is when the command behind it expires.
    """

    twist: Twist = STANDSTILL
    axes: Mapping[str, float] = field(default_factory=dict)
    reason: Sentence | None = None
    limit: Sentence | None = None
    soft: bool = False
    holds: bool = False
    valid_until_s: float = math.inf


def begin(turn: int, now_s: float) -> GateState:
    """Return the state at the start of a turn, or when its operator reconnects."""
    return GateState(turn=turn, hold_since_s=now_s)


def require_neutral(state: GateState, now_s: float, why: Hold) -> GateState:
    """Forget the command; nothing moves until a neutral one sent after `now_s` arrives."""
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
    """Accept a command that has just arrived, or return why not; a refused one moves nothing."""
    refusal = _foreign(state, viewer, command, turn)
    if refusal is not None:
        return state, refusal
    # A timestamp in the future must not make the command, or the sender's picture, last longer.
    seen_s = video_freshness.credible_seen_s(command.seen_s, now_s, turn.one_way_s)
    sent_s = credible_sent_s(command.sent_s, command.heard_s, now_s, one_way_s=turn.one_way_s)
    refusal = _unusable(command, sent_s, turn, now_s, rules)
    refusal = refusal or _unseeing(state, seen_s, turn, now_s, rules)
    if refusal is not None:
        return replace(state, refused=refusal), refusal
    command = replace(command, sent_s=sent_s, seen_s=seen_s)
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
    """Return the set-point for now, within the limits whatever the command says.

    Call it on every tick: the returned state tracks how long an interruption has lasted.
    """
    outranked = _outranked(turn, stop)
    if outranked is not None:
        why, reason = outranked
        return require_neutral(state, now_s, why), Setpoint(reason=reason)
    ttl_s = time_to_live_s(turn.one_way_s, rules)
    if turn.operator is None or not turn.present or state.turn != turn.number or ttl_s is None:
        return state, Setpoint(reason=_refusal(state, turn))
    command = state.command
    if command is None:
        return state, _held_back(state)
    seen = video_freshness.judge(command.seen_s, now_s, turn, rules)
    lapse = _lapse(command, seen, turn, now_s, ttl_s)
    if now_s - state.well_s > LAPSE_S:
        state = require_neutral(state, now_s, Hold.LAPSED)
        return state, _held_back(state)
    if lapse is not None:
        setpoint = Setpoint(reason=(state.refused or lapse).value, soft=True)
        return replace(state, lapsed=True), setpoint
    setpoint = _driven(command, seen, turn, ttl_s, rules)
    return replace(state, well_s=now_s, lapsed=False), _let_pass(setpoint, turn)


def _outranked(turn: TurnView, stop: LatchedStop | None) -> tuple[Hold, Sentence] | None:
    """Return why nobody may drive, the person aboard or a stop, with a sentence for it."""
    if turn.aboard is not None and turn.aboard.mode != "free":
        return Hold.ABOARD, ABOARD[turn.aboard.mode]
    return None if stop is None else (Hold.STOPPED, stopped_by(stop.by))


def _foreign(state: GateState, viewer: int, command: Command, turn: TurnView) -> Refusal | None:
    """Refuse a command that is not the next of this turn's operator."""
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
    command: Command, sent_s: float, turn: TurnView, now_s: float, rules: Rules
) -> Refusal | None:
    """Refuse an invalid or stale command, whoever sends it; `sent_s` is the credible time."""
    if not command.is_in_range:
        return Refusal.OUT_OF_RANGE
    ttl_s = time_to_live_s(turn.one_way_s, rules)
    if ttl_s is None:
        return Refusal.TOO_SLOW
    if is_too_old(sent_s, now_s, ttl_s):
        return Refusal.TOO_OLD
    if is_from_future(command.sent_s, now_s, one_way_s=turn.one_way_s):
        return Refusal.FROM_FUTURE
    return None


def _unseeing(
    state: GateState, seen_s: float | None, turn: TurnView, now_s: float, rules: Rules
) -> Refusal | None:
    """Refuse to start driving without a picture: the operator could not see an obstacle."""
    is_blind = video_freshness.judge(seen_s, now_s, turn, rules) is VideoFreshness.NONE
    return _blind(turn) if is_blind and state.command is None else None


def _refusal(state: GateState, turn: TurnView) -> Sentence:
    """Return why no command may move the robot."""
    if turn.operator is None:
        return NOBODY_DRIVES
    if not turn.present:
        return Refusal.LOST.value
    return Hold.TURN_STARTED.value if state.turn != turn.number else Refusal.TOO_SLOW.value


def _held_back(state: GateState) -> Setpoint:
    """Stand still until everything is released."""
    return Setpoint(reason=(state.refused or state.hold).value, soft=state.hold is Hold.LAPSED)


def _lapse(
    command: Command, seen: VideoFreshness, turn: TurnView, now_s: float, ttl_s: float
) -> Refusal | None:
    """Return what is interrupted now, the commands or the picture; it may soon resume."""
    if is_too_old(command.sent_s, now_s, ttl_s):
        return Refusal.TOO_OLD
    return _blind(turn) if seen is VideoFreshness.NONE else None


def _blind(turn: TurnView) -> Refusal:
    """Return why there is no picture to drive by."""
    return Refusal.BLIND if turn.picture.doubted_s is None else Refusal.UNDATED


def _driven(
    command: Command, seen: VideoFreshness, turn: TurnView, ttl_s: float, rules: Rules
) -> Setpoint:
    """Turn an accepted command into a set-point; without the dead-man held no axis moves either."""
    if not command.held:
        return Setpoint(reason=NOT_HELD if command.asks_for_motion else None, soft=True)
    limits = rules.limits
    axes = {name: command.axes[name] for name in limits.axes if name in command.axes}
    twist, limit = speed.twist(command, seen, ttl_s, rules, turn.max_fraction)
    if not _is_within(twist, limits):
        return Setpoint(reason=NO_LIMITS)
    return Setpoint(
        twist,
        axes,
        limit=None if limit is None else limit.value,
        soft=True,
        holds=True,
        valid_until_s=command.sent_s + ttl_s,
    )


def _let_pass(setpoint: Setpoint, turn: TurnView) -> Setpoint:
    """Stop the robot if the person aboard shares and lets nothing through; the robot does scale."""
    share = 1.0 if turn.aboard is None else turn.aboard.share
    if setpoint.twist.is_zero or share >= 1.0:
        return setpoint
    if share > 0.0:
        return replace(setpoint, limit=Limit.SHARED.value)
    return Setpoint(axes=setpoint.axes, reason=NOT_LET, soft=True)


def _is_within(twist: Twist, limits: Limits) -> bool:
    """Check the result too: even one of the robot's own limits may be NaN."""
    parts = (
        (twist.linear_mps, limits.linear_mps),
        (twist.angular_rps, limits.angular_rps),
        (twist.lateral_mps, limits.lateral_mps),
    )
    are_within = all(abs(part) <= most < math.inf for part, most in parts)
    return are_within and share_of(twist, limits) <= 1.0 + _ROUNDING
