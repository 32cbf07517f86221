"""The gate, rule by rule."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, get_args

import pytest
from tests.control.rules import RULES, VOUCHED

from wax.control import gate, speed
from wax.control.command import Command
from wax.control.gate import GateState, Setpoint
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
from wax.control.stop_latch import LatchedStop
from wax.control.turn_view import TurnView
from wax.driver.interface import STANDSTILL, Aboard, HandMode, Limits, Twist
from wax.sentence import says

if TYPE_CHECKING:
    from wax.control.rules import Rules

OPERATOR, OTHER = 7, 8
TURN = TurnView(
    number=3, operator=OPERATOR, present=True, one_way_s=0.1, sees=True, picture=VOUCHED
)
START_S = 100.0


def command(seq: int, sent_s: float, linear: float = 0.0, angular: float = 0.0) -> Command:
    """Make a command with the dead-man held for any motion, and with a fresh picture."""
    return Command(
        seq=seq,
        turn=3,
        sent_s=sent_s,
        linear=linear,
        angular=angular,
        held=linear != 0 or angular != 0,
        speed="fast",
        seen_s=sent_s,
        heard_s=sent_s,
    )


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
    return gate.accept(state, viewer, offered, turn=turn, now_s=now_s, rules=RULES)


def decide(
    state: GateState,
    now_s: float,
    turn: TurnView = TURN,
    *,
    stop: LatchedStop | None = None,
    rules: Rules = RULES,
) -> Setpoint:
    return gate.decide(state, turn, stop, now_s, rules)[1]


def beats(state: GateState, from_s: float, to_s: float, turn: TurnView = TURN) -> GateState:
    """Call the gate every 20 ms in between, as the loop does."""
    for number in range(round((to_s - from_s) * 50)):
        state, _ = gate.decide(state, turn, None, from_s + number / 50, RULES)
    return state


AHEAD = Twist(0.8, 0.0)
STANDING = Setpoint(soft=True)


def held_back(why: Hold) -> Setpoint:
    return Setpoint(reason=why.value, soft=why is Hold.LAPSED)


def trace(
    state: GateState,
    *ticks: tuple[float, Command | LatchedStop | None, Setpoint | Twist],
    turn: TurnView = TURN,
) -> GateState:
    """Play ticks: when, what arrives, and what the robot gets; return the gate after them.

    A Stop is in force for one tick. An operator whose command is refused is told why.
    """
    for now_s, arrives, gets in ticks:
        stop, refusal = None, None
        if isinstance(arrives, LatchedStop):
            stop = arrives
        elif arrives is not None:
            state, refusal = offer(state, arrives, turn=turn, now_s=now_s)
        state, setpoint = gate.decide(state, turn, stop, now_s, RULES)
        assert gets == (setpoint.twist if isinstance(gets, Twist) else setpoint), f"at {now_s} s"
        assert refusal is None or setpoint.reason == refusal.value, f"at {now_s} s"
    return state


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


def test_a_turn() -> None:
    """A held key waits for neutral; driving goes on after a short gap, but not after a long one."""
    trace(
        gate.begin(3, 100.0),
        # when, what arrives, and what the robot gets
        (100.10, command(1, 100.10, linear=1.0), held_back(Hold.TURN_STARTED)),
        (100.20, command(2, 100.20), STANDING),
        (100.30, command(3, 100.30, linear=1.0), AHEAD),
        (100.54, None, AHEAD),
        (100.56, None, Setpoint(reason=Refusal.TOO_OLD.value, soft=True)),  # 0.15 + 0.1 s
        (101.30, command(4, 101.30, linear=1.0), AHEAD),
        (102.40, command(5, 102.40, linear=1.0), held_back(Hold.LAPSED)),  # after 1.1 s
        (102.50, command(6, 102.50), STANDING),
        (102.60, command(7, 102.60, linear=1.0), AHEAD),
    )


def test_neutral_then_drive_moves() -> None:
    """After neutral, the operator's fresh command becomes motion, scaled by the limits."""
    state, _ = offer(ready(), command(11, 101.1, linear=-0.5, angular=0.25))
    expected = Setpoint(Twist(-0.4, 0.5), soft=True, holds=True, valid_until_s=101.1 + 0.25)
    assert decide(state, 101.1) == expected


def test_fine_speed() -> None:
    """Slow speed multiplies by slow_fraction."""
    state, _ = offer(ready(), replace(command(11, 101.1, 1.0, -1.0), speed="slow"))
    assert decide(state, 101.1).twist == Twist(0.4, -1.0)


def test_axes_of_the_robot_pass() -> None:
    """A position passes for the axes that the robot has; others are left out."""
    axes = {"pan": -0.5, "arm": 0.5}
    state, _ = offer(ready(), replace(command(11, 101.1), held=True, axes=axes))
    expected = Setpoint(axes={"pan": -0.5}, soft=True, holds=True, valid_until_s=101.1 + 0.25)
    assert decide(state, 101.1) == expected


def test_neutral_command_needs_no_reason() -> None:
    """An operator who asks for no motion is told no reason why there is none."""
    assert decide(ready(), 101.1) == Setpoint(soft=True)


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
    "no number sideways": (Refusal.OUT_OF_RANGE, {}, {"lateral": math.nan}),
    "more than all": (Refusal.OUT_OF_RANGE, {}, {"linear": 1.001}),
    "less than nothing": (Refusal.OUT_OF_RANGE, {}, {"angular": -1.001}),
    "an axis out of range": (Refusal.OUT_OF_RANGE, {}, {"axes": {"pan": math.nan}}),
    "a stamp that is no number": (Refusal.OUT_OF_RANGE, {}, {"sent_s": math.nan}),
    "a line that is too long": (Refusal.TOO_SLOW, {"turn": replace(TURN, one_way_s=0.351)}, {}),
    "an old command": (Refusal.TOO_OLD, {"now_s": 101.451}, {}),
    "a command of the future": (Refusal.FROM_FUTURE, {"now_s": 101.049}, {}),
}


@pytest.mark.parametrize(("why", "circumstances", "change"), REFUSED.values(), ids=REFUSED)
def test_refused(why: Refusal, circumstances: dict[str, object], change: dict[str, object]) -> None:
    """A command that breaks one rule is refused for it, and the previous command still counts."""
    before = driving()
    offered = replace(command(12, 101.2, linear=0.5), **change)  # type: ignore[arg-type]  # a table
    after, refusal = offer(before, offered, **circumstances)  # type: ignore[arg-type]  # a table
    assert refusal is why
    assert (after.command, after.newest_seq) == (before.command, before.newest_seq)


def test_age_counts_from_the_senders_stamp() -> None:
    """A command counts for max_age_ms plus the measured delay after it was sent."""
    trace(
        ready(),
        (101.2, command(11, 101.1, linear=1.0), AHEAD),
        (101.349, None, AHEAD),
        (101.351, None, Setpoint(reason=Refusal.TOO_OLD.value, soft=True)),
    )


def test_unknown_delay_is_no_allowance() -> None:
    """Until the one-way delay is measured, the limit has no allowance."""
    unknown = replace(TURN, one_way_s=None)
    assert not decide(driving(), 101.249, unknown).twist.is_zero
    assert decide(driving(), 101.251, unknown).twist.is_zero


def test_stamp_ahead_does_not_last_longer() -> None:
    """A timestamp slightly ahead counts as the time of arrival."""
    trace(
        ready(),
        (101.1, command(11, 101.2, linear=1.0), AHEAD),
        (101.349, None, AHEAD),
        (101.351, None, STANDSTILL),
    )


def test_standstill_without_operator() -> None:
    """Nothing moves without an operator, with a lost one, or in a turn new to the gate."""
    state = driving()
    assert decide(state, 101.1, replace(TURN, operator=None)) == Setpoint(reason=NOBODY_DRIVES)
    lost = replace(TURN, present=False)
    assert decide(state, 101.1, lost) == Setpoint(reason=Refusal.LOST.value)
    other = replace(TURN, number=4)
    assert decide(state, 101.1, other) == Setpoint(reason=Hold.TURN_STARTED.value)


@pytest.mark.parametrize("why", Hold)
def test_hold_needs_a_later_neutral(why: Hold) -> None:
    """After a hold nothing moves until a neutral command that was sent after it has come."""
    trace(
        gate.require_neutral(driving(), 101.15, why),
        (101.15, None, held_back(why)),
        (101.2, command(12, 101.14), held_back(why)),  # sent before it
        (101.2, command(13, 101.149, linear=1.0), held_back(why)),
        (101.2, command(14, 101.2, linear=1.0), held_back(why)),
        (101.3, command(15, 101.3), STANDING),
        (101.4, command(16, 101.4, linear=1.0), AHEAD),
    )


def test_drive_sent_before_the_stop_does_not_count_after_release() -> None:
    """A command from before the stop moves nothing even after the release."""
    trace(
        gate.require_neutral(driving(), 101.15, Hold.STOPPED),
        (101.16, command(12, 101.16), STANDING),
        (101.17, command(13, 101.14, linear=1.0), STANDING),
    )


def test_a_gate_that_no_turn_has_begun_takes_nothing() -> None:
    """A gate that has not begun a turn refuses commands as another turn's."""
    first = replace(TURN, number=1)
    _, refusal = offer(GateState(), replace(command(1, 101.0), turn=1), turn=first)
    assert refusal is Refusal.OTHER_TURN


def test_new_turn_counts_its_commands_anew() -> None:
    """Sequence numbers restart with a turn, and with a new connection of its operator."""
    state, refusal = offer(gate.begin(3, 101.2), command(1, 101.3))
    assert refusal is None
    assert state.newest_seq == 1


def test_reason_tells_what_is_wrong_with_the_commands() -> None:
    """While commands are refused the operator is told why, until one counts."""
    ahead_of_time = Setpoint(reason=Refusal.FROM_FUTURE.value)
    trace(gate.begin(3, START_S), (100.5, command(1, 101.0), ahead_of_time))
    trace(
        driving(),
        (101.5, command(12, 103.0), replace(ahead_of_time, soft=True)),
        (101.6, command(13, 101.6), STANDING),
    )


def test_others_do_not_change_the_operators_reason() -> None:
    """An observer's command changes nothing for the operator."""
    before = driving()
    after, _ = offer(before, command(99, 101.2), viewer=OTHER)
    assert after is before


# --- the dead-man -----------------------------------------------------------------------------


def test_nothing_moves_that_is_not_held() -> None:
    """Without the dead-man the robot stands, whatever motion is asked for, and says why."""
    loose = replace(command(12, 101.2, linear=1.0), held=False)
    trace(
        driving(),
        (101.2, loose, Setpoint(reason=NOT_HELD, soft=True)),
        (101.3, command(13, 101.3, linear=1.0), AHEAD),
    )


@pytest.mark.parametrize("linear", [0.0, 1.0])
def test_no_axis_moves_that_is_not_held(linear: float) -> None:
    """Without the dead-man no axis moves."""
    loose = replace(command(12, 101.2, linear), held=False, axes={"pan": 0.5})
    state, refusal = offer(driving(), loose)
    assert refusal is None
    assert decide(state, 101.2).axes == {}


@pytest.mark.parametrize(
    "change",
    [
        {"held": True},
        {"held": True, "axes": {"pan": 0.5}},
        {"linear": 0.1},
        {"angular": 0.1},
        {"lateral": -0.1},
        {"linear": -0.1, "held": True},
    ],
)
def test_neutral_is_all_let_go(change: dict[str, object]) -> None:
    """Neither a held dead-man nor motion without it counts as neutral."""
    half = replace(command(1, 100.1), **change)  # type: ignore[arg-type]  # a table
    state, refusal = offer(gate.begin(3, START_S), half)
    assert refusal is None
    state, _ = offer(state, command(2, 100.2, linear=1.0))
    assert decide(state, 100.2) == Setpoint(reason=Hold.TURN_STARTED.value)


# --- the stop ---------------------------------------------------------------------------------


def test_nothing_moves_while_a_stop_is_latched() -> None:
    """While a stop is in force neither wheels nor axes move, and the reason names the presser."""
    state, _ = offer(driving(), replace(command(12, 101.2, linear=1.0), axes={"pan": 0.5}))
    stop = LatchedStop(1, says("Bob"))
    assert decide(state, 101.2, stop=stop) == Setpoint(reason=stopped_by(says("Bob")))


def test_release_alone_moves_nothing() -> None:
    """After a stop a held key moves nothing, nor what was sent while the stop lasted."""
    trace(
        driving(),
        (101.2, LatchedStop(1, says("Bob")), Setpoint(reason=stopped_by(says("Bob")))),
        (101.21, command(12, 101.19), held_back(Hold.STOPPED)),
        (101.22, command(13, 101.22, linear=1.0), held_back(Hold.STOPPED)),
        (101.24, command(14, 101.24), STANDING),
        (101.26, command(15, 101.26, linear=1.0), AHEAD),
    )


# --- the person aboard -------------------------------------------------------------------------


def aboard(mode: HandMode, share: float = 1.0) -> TurnView:
    return replace(TURN, aboard=Aboard(mode, share))


@pytest.mark.parametrize("mode", get_args(HandMode))
def test_only_a_person_who_leaves_the_robot_lets_an_operator_drive(mode: HandMode) -> None:
    """In every mode but ``free`` neither wheels nor axes move, and a sentence says why."""
    state, _ = offer(driving(), replace(command(12, 101.2, linear=1.0), axes={"pan": 0.5}))
    setpoint = decide(state, 101.2, aboard(mode))
    if mode == "free":
        assert setpoint == decide(state, 101.2)
    else:
        assert setpoint == Setpoint(reason=ABOARD[mode])


def test_the_person_aboard_comes_before_the_stop() -> None:
    """The person aboard is named as the reason before a stop, which stays latched."""
    stop = LatchedStop(1, says("Bob"))
    assert decide(driving(), 101.2, aboard("hand"), stop=stop).reason == ABOARD["hand"]
    assert decide(driving(), 101.2, aboard("free"), stop=stop).reason == stopped_by(says("Bob"))


def test_neutral_comes_first_after_the_person_aboard() -> None:
    """After the person lets go, neither a held key nor an earlier command moves the robot."""
    taken = (101.2, None, Setpoint(reason=ABOARD["hand"]))
    trace(
        trace(driving(), taken, turn=aboard("hand")),
        (101.21, command(12, 101.19), held_back(Hold.ABOARD)),
        (101.22, command(13, 101.22, linear=1.0), held_back(Hold.ABOARD)),
        (101.24, command(14, 101.24), STANDING),
        (101.26, command(15, 101.26, linear=1.0), AHEAD),
        turn=aboard("free"),
    )


def test_a_person_who_shares_slows_and_stands_without_neutral() -> None:
    """The robot scales by the person's stick; with it at rest only axes pass the gate."""
    state, _ = offer(driving(), replace(command(12, 101.2, linear=1.0), axes={"pan": 0.5}))
    whole = decide(state, 101.2)
    shared = decide(state, 101.2, aboard("free", 0.4))
    assert shared == replace(whole, limit=Limit.SHARED.value)
    state, none = gate.decide(state, aboard("free", 0.0), None, 101.2, RULES)
    assert (none.twist, none.reason, dict(none.axes)) == (STANDSTILL, NOT_LET, {"pan": 0.5})
    assert decide(state, 101.22, aboard("free", 1.0)) == whole


# --- the line, and what is seen ---------------------------------------------------------------


def test_too_long_a_line_is_for_watching() -> None:
    """Over a link with too much delay nothing moves, and the operator is told why."""
    slow = replace(TURN, one_way_s=0.351)
    assert decide(driving(), 101.1, slow) == Setpoint(reason=Refusal.TOO_SLOW.value)
    assert not decide(driving(), 101.1, replace(TURN, one_way_s=0.349)).twist.is_zero


@pytest.mark.parametrize("seen_s", [None, 100.19, 103.0, math.nan])
def test_who_does_not_see_does_not_drive(seen_s: float | None) -> None:
    """Without a fresh picture the robot stands, and the operator is told why."""
    blind = replace(command(12, 101.1, linear=1.0), seen_s=seen_s)
    state, refusal = offer(driving(), blind)
    assert refusal is None
    assert decide(state, 101.1) == Setpoint(reason=Refusal.BLIND.value, soft=True)


def test_picture_grows_old_between_two_commands() -> None:
    """The picture's age counts now, not when the command arrived."""
    state, _ = offer(driving(), replace(command(12, 101.1, linear=1.0), seen_s=100.7))
    assert decide(state, 101.19).limit is None
    assert decide(state, 101.21).limit == Limit.LATE_PICTURE.value
    state, _ = offer(driving(), replace(command(12, 101.1, linear=1.0), seen_s=100.3))
    assert not decide(state, 101.19).twist.is_zero
    assert decide(state, 101.21).reason == Refusal.BLIND.value


def test_picture_ahead_does_not_last_longer() -> None:
    """A picture time slightly ahead counts as the time of arrival."""
    late = replace(TURN, one_way_s=0.3)
    rules = replace(RULES, slow_picture_age_s=0.1, max_age_s=0.2)
    state, _ = offer(driving(), replace(command(12, 101.2, linear=1.0), seen_s=101.5), turn=late)
    assert decide(state, 101.59, late, rules=rules).limit is None
    assert decide(state, 101.61, late, rules=rules).limit == Limit.LATE_PICTURE.value


def test_limit_stands_beside_the_motion() -> None:
    """A limit slows the robot, and the operator is told why."""
    off = replace(TURN, sees=False)
    state, _ = offer(driving(), replace(command(12, 101.2, linear=1.0), seen_s=None), turn=off)
    setpoint = decide(state, 101.2, off)
    assert (setpoint.twist, setpoint.limit) == (Twist(0.4, 0.0), Limit.NO_PICTURE.value)
    assert setpoint.reason is None


def test_who_sees_nothing_has_not_let_go() -> None:
    """A neutral command sent without a picture does not count, and its sender is told why."""
    trace(
        gate.begin(3, START_S),
        (100.1, replace(command(1, 100.1), seen_s=None), Setpoint(reason=Refusal.BLIND.value)),
        (100.2, command(2, 100.2, linear=1.0), held_back(Hold.TURN_STARTED)),
    )


# --- lapses -----------------------------------------------------------------------------------


@pytest.mark.parametrize(("back_s", "gets"), [(102.3, AHEAD), (102.4, held_back(Hold.LAPSED))])
def test_after_a_silence(back_s: float, gets: Setpoint | Twist) -> None:
    """After up to a second of silence driving resumes; after longer neutral comes first."""
    state = beats(driving(), 101.1, back_s)  # fresh until 101.35
    trace(state, (back_s, command(12, back_s, linear=1.0), gets))


@pytest.mark.parametrize(("blind_s", "goes_on"), [(0.95, True), (1.1, False)])
def test_after_blindness(blind_s: float, goes_on: bool) -> None:
    """After up to a second without a picture driving resumes; after longer neutral comes first."""
    state, seq = beats(driving(), 101.1, 101.12), 11
    for number in range(round(blind_s * 50)):
        seq, now_s = seq + 1, 101.12 + number / 50
        blind = replace(command(seq, now_s, linear=1.0), seen_s=100.0)
        state, _ = offer(state, blind)
        state, setpoint = gate.decide(state, TURN, None, now_s, RULES)
        assert setpoint.twist == STANDSTILL
    now_s = 101.12 + blind_s
    state, _ = offer(state, command(seq + 1, now_s, linear=1.0))
    assert decide(state, now_s).twist.is_zero is not goes_on


def test_a_lapse_that_nobody_watched_counts_too() -> None:
    """Even without a tick in between, a command after a long silence moves nothing."""
    state, _ = offer(driving(), command(12, 103.0, linear=1.0))
    assert decide(state, 103.0) == Setpoint(reason=Hold.LAPSED.value, soft=True)


def test_a_lapse_of_just_a_second_ends_by_itself() -> None:
    """A lapse of exactly a second still ends by itself."""
    assert decide(ready(), 102.0).reason == Refusal.TOO_OLD.value
    assert decide(ready(), 102.001).reason == Hold.LAPSED.value


def test_who_lets_go_is_heard_anew_at_each_beat() -> None:
    """An operator who stood still for a minute with a fresh picture can drive on at once."""
    state = ready()
    for seq in range(11, 3011):
        state, _ = offer(state, command(seq, 101.0 + (seq - 10) / 50))
        state, _ = gate.decide(state, TURN, None, 101.0 + (seq - 10) / 50, RULES)
    state, _ = offer(state, command(3011, 161.02, linear=1.0))
    assert decide(state, 161.02).twist == Twist(0.8, 0.0)


# --- what comes out ---------------------------------------------------------------------------


@pytest.mark.parametrize("wrong", [math.nan, math.inf, -1.0])
@pytest.mark.parametrize("part", ["linear_mps", "angular_rps", "lateral_mps"])
def test_limits_that_are_no_numbers(wrong: float, part: str) -> None:
    """A robot whose driver reports invalid limits stands, and the operator is told why."""
    limits = replace(Limits(linear_mps=0.8, angular_rps=2.0), **{part: wrong})  # type: ignore[arg-type]  # a table
    curve, _ = offer(ready(), command(11, 101.02, linear=1.0, angular=0.5))
    setpoint = decide(curve, 101.1, rules=replace(RULES, limits=limits))
    assert setpoint == Setpoint(reason=NO_LIMITS)


@pytest.mark.parametrize(
    ("twist", "passes"),
    [
        (Twist(-0.8, 2.0), True),
        (Twist(0.0, 2.0, -0.4), True),
        (Twist(0.8, 0.0, 0.4 * math.sqrt(2e-9)), True),  # longer by 1e-9, as rounding makes it
        (Twist(0.8, 0.0, 0.01), False),
        (Twist(0.6, 0.0, -0.3), False),
        (Twist(0.0, 2.01), False),
    ],
)
def test_what_comes_out_is_judged_anew(
    twist: Twist, passes: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever the speed was calculated to be, no more than the limits passes in any direction."""
    monkeypatch.setattr(speed, "twist", lambda *_: (twist, None))
    ahead, _ = offer(ready(), command(11, 101.02, linear=1.0))
    setpoint = decide(ahead, 101.1)
    assert setpoint.twist == (twist if passes else STANDSTILL)
    assert setpoint.reason == (None if passes else NO_LIMITS)
