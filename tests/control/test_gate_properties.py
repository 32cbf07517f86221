"""Gate, latch and ramp against random traces on a bad network."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

from hypothesis import example, given
from hypothesis import strategies as st
from tests.control.rules import RULES, VOUCHED
from tests.control.velocity import fraction, gained, is_same, velocity
from tests.examples import examples

from wax.control import gate, ramp, stop_latch
from wax.control.command import Command
from wax.control.picture_clock import PictureClock
from wax.control.reasons import Hold
from wax.control.stop_latch import StopLatch
from wax.control.turn_view import TurnView
from wax.driver.interface import STANDSTILL, Aboard, HandMode, Limits, Twist
from wax.sentence import says

LIMITS = RULES.limits
LEAVES = Aboard("free")
"""A person aboard who lets the operator drive."""
OPERATOR = 1
TURN = 5

any_share = st.one_of(
    st.sampled_from([0.0, 0.0, 1.0, -1.0, 0.5]),
    st.floats(-1, 1),
    st.floats(allow_nan=True, allow_infinity=True),
)
full = st.sampled_from([0.0, 1.0, -1.0])


@dataclass(frozen=True)
class Word:
    """One thing that happens: the gap before it, and what it is."""

    gap_s: float
    what: str
    viewer: int = OPERATOR
    turn: int = TURN
    seq_back: int = 0  # how far the sequence number lies behind the highest sent
    delay_s: float = 0.0
    heard_s: float = 0.0  # how long before it arrived the newest beat was sent that it names
    hands: tuple[float, float, float, bool] = (0.0, 0.0, 0.0, False)
    speed: str = "fast"
    picture_s: float | None = 0.0  # how old what is seen was when the command was sent
    axes: dict[str, float] = field(default_factory=dict)
    mode: HandMode = "hand"


words = st.builds(
    Word,
    gap_s=st.sampled_from([0.0, 0.01, 0.02, 0.02, 0.033, 0.1, 0.14, 0.16, 0.3]),
    what=st.sampled_from(
        ["drive"] * 24
        + ["fault", "press", "release", "release", "lose", "return", "return", "shut", "open"]
        + ["touch", "let go", "let go"]
    ),
    viewer=st.sampled_from([OPERATOR] * 6 + [2]),
    turn=st.sampled_from([TURN] * 6 + [TURN - 1, TURN + 1]),
    seq_back=st.sampled_from([0] * 6 + [1, 2]),
    delay_s=st.one_of(st.just(0.0), st.just(0.0), st.floats(0.0, 0.2), st.floats(-0.3, 0.5)),
    heard_s=st.one_of(st.just(0.0), st.floats(0.0, 1.0), st.just(math.inf)),
    hands=st.one_of(
        st.just((0.0, 0.0, 0.0, False)),
        st.tuples(st.floats(-1, 1), full, full, st.just(True)),
        st.tuples(st.just(0.0), st.just(0.0), full, st.booleans()),
        st.tuples(any_share, any_share, any_share, st.booleans()),
    ),
    speed=st.sampled_from(["slow", "fast"]),
    picture_s=st.one_of(st.sampled_from([0.0] * 5 + [0.45, 0.9, None]), st.floats(-0.5, 1.5)),
    axes=st.dictionaries(st.sampled_from(["pan", "arm"]), any_share, max_size=2),
    mode=st.sampled_from(["hand", "pause", "stopped", "lost"]),
)


@dataclass
class Judge:
    """A naive second implementation of the rules, which remembers everything."""

    one_way_s: float
    hold_s: float
    present: bool = True
    sees: bool = True
    picture: PictureClock = VOUCHED
    taken_by: Aboard = LEAVES
    stopped: bool = False
    taken: list[Command] = field(default_factory=list)
    released: bool = False
    well_s: float = 0.0

    def turn(self) -> TurnView:
        return TurnView(
            TURN,
            OPERATOR,
            self.present,
            self.one_way_s,
            self.sees,
            self.picture,
            aboard=self.taken_by,
        )

    def hold(self, now_s: float) -> None:
        self.hold_s, self.released = now_s, False

    def hear(self, viewer: int, command: Command, now_s: float) -> None:
        hands = [command.linear, command.angular, command.lateral]
        numbers = [*hands, *command.axes.values()]
        seen_s = command.seen_s
        if seen_s is not None and seen_s - now_s > 0.05 + self.one_way_s:
            seen_s = None
        seen_s = None if seen_s is None else min(seen_s, now_s)
        # By the server's clock alone it was sent no later than this.
        sent_s = min(command.sent_s, now_s, command.heard_s + self.one_way_s + 0.35)
        rules = [
            viewer == OPERATOR and self.present,
            command.turn == TURN,
            all(command.seq > other.seq for other in self.taken),
            all(math.isfinite(n) and abs(n) <= 1 for n in numbers),
            now_s - sent_s <= 0.15 + self.one_way_s,
            command.sent_s - now_s <= 0.05 + self.one_way_s,
            self.newest() is not None or self.sight(seen_s, now_s) != "none",
        ]
        if all(rules):
            command = replace(command, sent_s=sent_s, seen_s=seen_s)
            self.taken.append(command)
            hands_off = not any(hands) and not command.held
            if hands_off and command.sent_s >= self.hold_s and not self.released:
                self.released, self.well_s = True, now_s

    def newest(self) -> Command | None:
        """Return the newest command sent since the hold, once that is released."""
        since = [c for c in self.taken if c.sent_s >= self.hold_s]
        return since[-1] if since and self.released else None

    def sight(self, seen_s: float | None, now_s: float) -> str:
        if not self.sees:
            return "off"
        if seen_s is None or not seen_s >= self.picture.since_s:
            return "none"
        age_s = now_s - seen_s + self.picture.within_s - self.one_way_s
        return "clear" if age_s <= 0.4 else "late" if age_s <= 0.8 else "none"

    def allows(self, now_s: float) -> Command | None:
        """Return the command that the robot may follow now."""
        if self.stopped or self.taken_by != LEAVES:
            self.hold(now_s)
        newest = self.newest()
        if newest is None or not self.present:
            return None
        fresh = now_s - newest.sent_s <= 0.15 + self.one_way_s
        seeing = self.sight(newest.seen_s, now_s) != "none"
        if now_s - self.well_s > 1.0:
            self.hold(now_s)
            return None
        if not (fresh and seeing):
            return None
        self.well_s = now_s
        return newest


def expected(command: Command, sight: str) -> Twist:
    """Return the motion for a command that counts, for a robot that stops in time."""
    shares = [complex(command.linear, command.lateral), complex(command.angular)]
    if abs(shares[0]) > 1:
        shares[0] /= abs(shares[0])
    if command.speed == "slow":
        shares = [share * RULES.slow_fraction for share in shares]
    largest = max(map(abs, shares))
    if sight != "clear" and largest > RULES.slow_fraction:
        shares = [share * (RULES.slow_fraction / largest) for share in shares]
    return Twist(
        shares[0].real * LIMITS.linear_mps,
        shares[1].real * LIMITS.angular_rps,
        shares[0].imag * LIMITS.lateral_mps,
    )


@examples(400)
@given(
    st.lists(words, min_size=10, max_size=80),
    st.sampled_from([0.0, 0.02, 0.2]),
    st.sampled_from([VOUCHED, VOUCHED, PictureClock(1000.5, 0.3), PictureClock(doubted_s=0.0)]),
)
def test_motion_only_by_the_rules(
    trace: list[Word], one_way_s: float, picture: PictureClock
) -> None:
    """Whatever is repeated, reordered, delayed or forged, only the newest valid command moves."""
    now_s, seq = 1000.0, 10
    state, stop = gate.begin(TURN, now_s), StopLatch()
    judge = Judge(one_way_s=one_way_s, hold_s=now_s, picture=picture)
    for word in trace:
        now_s += word.gap_s
        turn = judge.turn()
        match word.what:
            case "drive":
                seq += 1
                sent_s = now_s - word.delay_s
                command = Command(
                    seq=seq - word.seq_back,
                    turn=word.turn,
                    sent_s=sent_s,
                    linear=word.hands[0],
                    angular=word.hands[1],
                    lateral=word.hands[2],
                    held=word.hands[3],
                    speed="slow" if word.speed == "slow" else "fast",
                    seen_s=None if word.picture_s is None else sent_s - word.picture_s,
                    axes=word.axes,
                    heard_s=now_s - word.heard_s,
                )
                judge.hear(word.viewer, command, now_s)
                state, _ = gate.accept(
                    state, word.viewer, command, turn=turn, now_s=now_s, rules=RULES
                )
            case "fault":
                state = gate.require_neutral(state, now_s, Hold.FAULT)
                judge.hold(now_s)
            case "press":
                stop = stop_latch.press(stop, says("Bob"), now_s)
                judge.stopped = True
            case "release":
                stop, _ = stop_latch.release(
                    stop, word.viewer, stop.newest, now_s, turn=turn, now_s=now_s
                )
                judge.stopped = judge.stopped and not (word.viewer == OPERATOR and judge.present)
                assert judge.stopped is (stop.stop is not None)
            case "lose" | "return":
                judge.present = word.what == "return"
            case "touch" | "let go":
                judge.taken_by = LEAVES if word.what == "let go" else Aboard(word.mode)
            case _:
                judge.sees = word.what == "open"
        turn = judge.turn()
        state, setpoint = gate.decide(state, turn, stop.stop, now_s, RULES)

        allowed = judge.allows(now_s)
        if allowed is None:
            assert setpoint.twist == STANDSTILL
            assert not setpoint.axes
            assert setpoint.reason
        elif not allowed.held:
            assert setpoint.twist == STANDSTILL
            assert not setpoint.axes
            asks = any((allowed.linear, allowed.angular, allowed.lateral))
            assert (setpoint.reason is not None) is asks
        else:
            assert setpoint.reason is None
            motion = expected(allowed, judge.sight(allowed.seen_s, now_s))
            assert is_same(setpoint.twist, motion)
            assert setpoint.valid_until_s == allowed.sent_s + (0.15 + one_way_s)
            pan = allowed.axes.get("pan")
            assert setpoint.axes == ({} if pan is None else {"pan": pan})


@given(
    hands=st.tuples(any_share, any_share, any_share),
    pan=any_share,
    sent_s=st.floats(),
    seen_s=st.floats(),
)
def test_no_number_gets_past_the_gate(
    hands: tuple[float, float, float], pan: float, sent_s: float, seen_s: float
) -> None:
    """NaN, infinity and values out of range are refused, and the robot stands."""
    turn = TurnView(
        number=TURN, operator=OPERATOR, present=True, one_way_s=0.3, sees=True, picture=VOUCHED
    )
    neutral = Command(1, TURN, 0.5, 0, 0, False, "fast", seen_s=0.5, heard_s=0.5)
    state, _ = gate.accept(
        gate.begin(TURN, 0.0), OPERATOR, neutral, turn=turn, now_s=0.5, rules=RULES
    )
    linear, angular, lateral = hands
    wild = Command(
        2, TURN, sent_s, linear, angular, True, "fast", seen_s, {"pan": pan}, 0.5, lateral
    )
    state, refusal = gate.accept(state, OPERATOR, wild, turn=turn, now_s=0.5, rules=RULES)
    sound = all(abs(n) <= 1 for n in (*hands, pan)) and math.isfinite(sent_s)
    assert sound or refusal is not None
    _, setpoint = gate.decide(state, turn, None, 0.5, RULES)
    assert fraction(setpoint.twist, LIMITS) <= 1 + 1e-9
    assert abs(setpoint.twist.angular_rps) <= LIMITS.angular_rps
    sees = math.isfinite(seen_s) and -0.6 <= seen_s <= 0.85
    assert (sound and sees) or setpoint.twist == STANDSTILL


weird = st.one_of(st.floats(), st.floats(0, 10), st.sampled_from([0.0, -1.0, math.inf, math.nan]))
positive = st.floats(1e-3, 100.0)


@given(
    shares=st.tuples(st.floats(-1, 1), st.floats(-1, 1), st.floats(-1, 1)),
    limits=st.builds(Limits, linear_mps=weird, angular_rps=weird, lateral_mps=weird),
    one_way_s=st.one_of(st.none(), st.floats(), st.floats(0, 0.4)),
    distance_m=positive,
    braking_mps2=positive,
)
@example((1.0, 0.0, 1.0), Limits(0.8, 2.0, lateral_mps=5e-324), None, 2.0, 2.0)
@example((1.0, 0.0, 1.0), Limits(0.8, 2.0, lateral_mps=math.nan), None, 2.0, 2.0)
@example((1.0, 0.0, 1.0), Limits(0.8, 2.0, lateral_mps=math.inf), None, 2.0, 2.0)
def test_no_number_of_the_robots_own_gets_out(
    shares: tuple[float, float, float],
    limits: Limits,
    one_way_s: float | None,
    distance_m: float,
    braking_mps2: float,
) -> None:
    """Whatever limits a driver gives, what comes out is within them and finite, or standstill."""
    rules = replace(RULES, limits=limits, max_stop_distance_m=distance_m, braking_mps2=braking_mps2)
    turn = TurnView(TURN, OPERATOR, present=True, one_way_s=one_way_s, sees=True, picture=VOUCHED)
    state = gate.begin(TURN, 0.0)
    for seq, hands in enumerate([(0.0, 0.0, 0.0), shares]):
        command = commanded(seq, 0.5, hands, 0.5)
        state, _ = gate.accept(state, OPERATOR, command, turn=turn, now_s=0.5, rules=rules)
    _, setpoint = gate.decide(state, turn, None, 0.5, rules)
    for part, limit in (
        (setpoint.twist.linear_mps, limits.linear_mps),
        (setpoint.twist.angular_rps, limits.angular_rps),
        (setpoint.twist.lateral_mps, limits.lateral_mps),
    ):
        assert part == 0 or abs(part) <= limit < math.inf
    assert fraction(setpoint.twist, limits) <= 1 + 1e-9


def commanded(seq: int, sent_s: float, hands: tuple[float, float, float], seen_s: float) -> Command:
    """Return a command at full speed that is held if anything is asked for."""
    linear, angular, lateral = hands
    return Command(
        seq,
        TURN,
        sent_s,
        linear,
        angular,
        any(hands),
        "fast",
        seen_s=seen_s,
        heard_s=sent_s,
        lateral=lateral,
    )


moments = st.tuples(
    st.sampled_from([0.0, 0.005, 0.02, 0.02, 0.04, 0.3]),
    st.one_of(
        st.none(),
        st.tuples(full, full, full),
        st.just((0.3, 0.1, 0.0)),
        st.just((0.2, 0.0, -0.7)),
    ),
    st.sampled_from([0.0, 0.0, 0.6, 2.0]),
)


@given(trace=st.lists(moments, min_size=5, max_size=60), soft_braking=st.booleans())
def test_never_faster_by_more_than_the_acceleration(
    trace: list[tuple[float, tuple[float, float, float] | None, float]], soft_braking: bool
) -> None:
    """Set-points stay within the limits and never accelerate faster than allowed."""
    rules = replace(RULES, soft_braking=soft_braking)
    turn = TurnView(TURN, OPERATOR, present=True, one_way_s=None, sees=True, picture=VOUCHED)
    now_s, told = 1000.0, STANDSTILL
    state = gate.begin(TURN, now_s)
    for seq, (gap_s, hands, picture_s) in enumerate([(0.02, (0.0, 0.0, 0.0), 0.0), *trace]):
        now_s += gap_s
        if hands is not None:
            command = commanded(seq, now_s, hands, now_s - picture_s)
            state, _ = gate.accept(state, OPERATOR, command, turn=turn, now_s=now_s, rules=rules)
        state, setpoint = gate.decide(state, turn, None, now_s, rules)
        before, told = told, ramp.step(setpoint, told, gap_s, rules).twist
        assert fraction(told, LIMITS) <= 1 + 1e-9
        assert abs(told.angular_rps) <= LIMITS.angular_rps
        for was, now, acceleration in (
            (velocity(before), velocity(told), rules.acceleration_mps2),
            (before.angular_rps, told.angular_rps, rules.acceleration_rps2),
        ):
            assert gained(was, now) <= acceleration * min(gap_s, 0.04) + 1e-9
        if setpoint.reason is not None and not soft_braking:
            assert told == STANDSTILL
