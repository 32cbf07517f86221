"""The gate, rule by rule."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from wax.config import DriveSettings
from wax.control import gate
from wax.control.gate import Command, GateState, Hold, Refusal, Setpoint, TurnView
from wax.robot.driver import STANDSTILL, Limits, Twist

OPERATOR, OTHER = 7, 8
SETTINGS = DriveSettings(max_age_ms=150.0, fine_fraction=0.5)
LIMITS = Limits(linear_mps=0.8, angular_rps=2.0, axes=("pan",))
TURN = TurnView(number=3, operator=OPERATOR, present=True, one_way_s=0.1)
START_S = 100.0


def command(seq: int, sent_s: float, linear: float = 0.0, angular: float = 0.0) -> Command:
    return Command(seq=seq, turn=3, sent_s=sent_s, linear=linear, angular=angular, speed="gross")


def offer(
    state: GateState,
    offered: Command,
    *,
    viewer: int = OPERATOR,
    turn: TurnView = TURN,
    now_s: float | None = None,
) -> tuple[GateState, Refusal | None]:
    """Offer a command that arrives at once, or at `now_s`."""
    now_s = offered.sent_s if now_s is None else now_s
    return gate.accept(state, viewer, offered, turn=turn, now_s=now_s, settings=SETTINGS)


def decide(state: GateState, now_s: float, turn: TurnView = TURN) -> Setpoint:
    return gate.decide(state, turn, now_s, SETTINGS, LIMITS)


def ready() -> GateState:
    """Return a gate that has seen neutral, number 10, at 101 s."""
    state, refusal = offer(gate.begin(3, START_S), command(10, 101.0))
    assert refusal is None
    return state


def driving() -> GateState:
    """Return a gate whose newest command, number 11 of 101.1 s, drives straight ahead."""
    state, refusal = offer(ready(), command(11, 101.1, linear=1.0))
    assert refusal is None
    assert decide(state, 101.1).twist == Twist(0.8, 0.0)
    return state


def test_neutral_then_drive_moves() -> None:
    """After neutral, the operator's fresh command becomes motion, scaled by the limits."""
    state, _ = offer(ready(), command(11, 101.1, linear=-0.5, angular=0.25))
    assert decide(state, 101.1) == Setpoint(Twist(-0.4, 0.5))


def test_fine_speed() -> None:
    """Fine multiplies by fine_fraction."""
    state, _ = offer(ready(), replace(command(11, 101.1, 1.0, -1.0), speed="fine"))
    assert decide(state, 101.1).twist == Twist(0.4, -1.0)


def test_axes_of_the_robot_pass() -> None:
    """A position passes for the axes that the robot has; others are left out."""
    state, _ = offer(ready(), replace(command(11, 101.1), axes={"pan": -0.5, "arm": 0.5}))
    assert decide(state, 101.1) == Setpoint(axes={"pan": -0.5})


def test_neutral_command_needs_no_reason() -> None:
    """An operator who asks for no motion is told no reason why there is none."""
    assert decide(ready(), 101.1) == Setpoint()


REFUSED = {
    "another viewer": (Refusal.NOT_YOUR_TURN, {"viewer": OTHER}, {}),
    "nobody's turn": (Refusal.NOT_YOUR_TURN, {"turn": replace(TURN, operator=None)}, {}),
    "a lost operator": (Refusal.LOST, {"turn": replace(TURN, present=False)}, {}),
    "an earlier turn": (Refusal.OTHER_TURN, {}, {"turn": 2}),
    "a later turn": (Refusal.OTHER_TURN, {}, {"turn": 4}),
    "a gate of an earlier turn": (
        Refusal.OTHER_TURN,
        {"turn": replace(TURN, number=4)},
        {"turn": 4},
    ),
    "a repeated command": (Refusal.OUT_OF_ORDER, {}, {"seq": 11}),
    "an overtaken command": (Refusal.OUT_OF_ORDER, {}, {"seq": 10}),
    "NaN": (Refusal.OUT_OF_RANGE, {}, {"linear": math.nan}),
    "infinity": (Refusal.OUT_OF_RANGE, {}, {"angular": -math.inf}),
    "more than all": (Refusal.OUT_OF_RANGE, {}, {"linear": 1.001}),
    "less than nothing": (Refusal.OUT_OF_RANGE, {}, {"angular": -1.001}),
    "an axis out of range": (Refusal.OUT_OF_RANGE, {}, {"axes": {"pan": math.nan}}),
    "a stamp that is no number": (Refusal.OUT_OF_RANGE, {}, {"sent_s": math.nan}),
    "an old command": (Refusal.TOO_OLD, {"now_s": 101.451}, {}),
    "a command of the future": (Refusal.FROM_FUTURE, {"now_s": 101.049}, {}),
}


@pytest.mark.parametrize(("why", "circumstances", "change"), REFUSED.values(), ids=REFUSED)
def test_refused(why: Refusal, circumstances: dict[str, object], change: dict[str, object]) -> None:
    """A command that breaks one rule is refused for it, and what was driven before stays."""
    before = driving()
    offered = replace(command(12, 101.2, linear=0.5), **change)  # type: ignore[arg-type]  # a table
    after, refusal = offer(before, offered, **circumstances)  # type: ignore[arg-type]  # a table
    assert refusal is why
    assert (after.command, after.newest_seq) == (before.command, before.newest_seq)


def test_age_counts_from_the_senders_stamp() -> None:
    """A command is good for max_age_ms plus the measured delay after it was sent."""
    state, refusal = offer(ready(), command(11, 101.1, linear=1.0), now_s=101.2)
    assert refusal is None
    assert not decide(state, 101.349).twist.is_zero
    assert decide(state, 101.351) == Setpoint(reason=Refusal.TOO_OLD.value)


def test_unknown_delay_is_no_allowance() -> None:
    """Until the one-way delay is measured the plain limit holds."""
    unknown = replace(TURN, one_way_s=None)
    assert not decide(driving(), 101.249, unknown).twist.is_zero
    assert decide(driving(), 101.251, unknown).twist.is_zero


def test_stamp_ahead_does_not_last_longer() -> None:
    """A stamp somewhat ahead counts as of its arrival."""
    state, refusal = offer(ready(), command(11, 101.2, linear=1.0), now_s=101.1)
    assert refusal is None
    assert not decide(state, 101.349).twist.is_zero
    assert decide(state, 101.351).twist.is_zero


def test_standstill_without_operator() -> None:
    """Nothing moves without an operator, with a lost one, or in a turn new to the gate."""
    state = driving()
    assert decide(state, 101.1, replace(TURN, operator=None)) == Setpoint(reason=gate.NOBODY_DRIVES)
    lost = replace(TURN, present=False)
    assert decide(state, 101.1, lost) == Setpoint(reason=Refusal.LOST.value)
    other = replace(TURN, number=4)
    assert decide(state, 101.1, other) == Setpoint(reason=Hold.TURN_STARTED.value)


def test_turn_begins_with_neutral() -> None:
    """A key held down from before the turn moves nothing until it was released."""
    state, refusal = offer(gate.begin(3, START_S), command(1, 100.1, linear=1.0))
    assert refusal is None
    assert decide(state, 100.1) == Setpoint(reason=Hold.TURN_STARTED.value)
    state, _ = offer(state, command(2, 100.2))
    state, _ = offer(state, command(3, 100.3, linear=1.0))
    assert decide(state, 100.3).twist == Twist(0.8, 0.0)


@pytest.mark.parametrize("why", Hold)
def test_hold_needs_a_later_neutral(why: Hold) -> None:
    """After a hold nothing moves until a neutral command that was sent after it has come."""
    state = gate.require_neutral(driving(), 101.15, why)
    assert decide(state, 101.15) == Setpoint(reason=why.value)
    state, _ = offer(state, command(12, 101.2, linear=1.0))
    assert decide(state, 101.2) == Setpoint(reason=why.value)
    state, _ = offer(state, command(13, 101.3))
    assert decide(state, 101.3) == Setpoint()
    state, _ = offer(state, command(14, 101.4, linear=1.0))
    assert decide(state, 101.4).twist == Twist(0.8, 0.0)


def test_neutral_sent_before_the_stop_does_not_count() -> None:
    """What was under way when the operator pressed stop neither releases nor moves the robot."""
    state = gate.require_neutral(driving(), 101.15, Hold.STOPPED)
    state, refusal = offer(state, command(12, 101.14), now_s=101.2)
    assert refusal is None
    state, _ = offer(state, command(13, 101.149, linear=1.0), now_s=101.2)
    assert decide(state, 101.2) == Setpoint(reason=Hold.STOPPED.value)


def test_drive_sent_before_the_stop_does_not_count_after_release() -> None:
    """Also after the release a command from before the stop moves nothing."""
    state = gate.require_neutral(driving(), 101.15, Hold.STOPPED)
    state, _ = offer(state, command(12, 101.16))
    state, refusal = offer(state, command(13, 101.14, linear=1.0), now_s=101.17)
    assert refusal is None
    assert decide(state, 101.17).twist == STANDSTILL


def test_new_turn_counts_its_commands_anew() -> None:
    """The sequence starts afresh with a turn, and with a fresh connection of its operator's."""
    state, refusal = offer(gate.begin(3, 101.2), command(1, 101.3))
    assert refusal is None
    assert state.newest_seq == 1


def test_reason_tells_what_is_wrong_with_the_commands() -> None:
    """While the operator's commands are refused he is told why, until one counts."""
    state, _ = offer(gate.begin(3, START_S), command(1, 101.0), now_s=100.5)
    assert decide(state, 100.5).reason == Refusal.FROM_FUTURE.value
    state, _ = offer(driving(), command(12, 103.0), now_s=102.0)
    assert decide(state, 102.0).reason == Refusal.FROM_FUTURE.value
    state, _ = offer(state, command(13, 102.1))
    assert decide(state, 102.1).reason is None


def test_others_do_not_change_the_operators_reason() -> None:
    """What an observer sends changes nothing at all for the operator."""
    before = driving()
    after, _ = offer(before, command(99, 101.2), viewer=OTHER)
    assert after is before
