"""The gate against random traces on a bad network."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

from hypothesis import given, settings
from hypothesis import strategies as st

from wax.config import DriveSettings
from wax.control import gate
from wax.control.gate import Command, Hold, TurnView
from wax.robot.driver import Limits

SETTINGS = DriveSettings()
LIMITS = Limits(linear_mps=0.6, angular_rps=1.5, axes=("pan",))
OPERATOR = 1
TURN = 5

any_share = st.one_of(
    st.sampled_from([0.0, 0.0, 1.0, -1.0, 0.5]),
    st.floats(-1, 1),
    st.floats(allow_nan=True, allow_infinity=True),
)


@dataclass(frozen=True)
class Word:
    """One thing that happens: the gap before it, and what it is."""

    gap_s: float
    what: str  # "drive", "stop", "lose" or "return"
    viewer: int = OPERATOR
    turn: int = TURN
    seq_back: int = 0  # how far the sequence number lies behind the highest sent
    delay_s: float = 0.0
    hands: tuple[float, float] = (0.0, 0.0)
    speed: str = "gross"
    axes: dict[str, float] = field(default_factory=dict)


words = st.builds(
    Word,
    gap_s=st.sampled_from([0.0, 0.01, 0.033, 0.1, 0.14, 0.16, 0.3]),
    what=st.sampled_from(["drive"] * 20 + ["stop", "lose", "return", "return", "return"]),
    viewer=st.sampled_from([OPERATOR] * 6 + [2]),
    turn=st.sampled_from([TURN] * 6 + [TURN - 1, TURN + 1]),
    seq_back=st.sampled_from([0] * 6 + [1, 2]),
    delay_s=st.one_of(st.just(0.0), st.floats(0.0, 0.2), st.floats(-0.3, 0.5)),
    hands=st.one_of(
        st.just((0.0, 0.0)),
        st.tuples(st.floats(-1, 1), st.sampled_from([0.0, 1.0, -1.0])),
        st.tuples(any_share, any_share),
    ),
    speed=st.sampled_from(["fine", "gross"]),
    axes=st.dictionaries(st.sampled_from(["pan", "arm"]), any_share, max_size=2),
)


@dataclass
class Judge:
    """The rules once more, naively: it remembers everything and forgets nothing."""

    max_age_s: float
    hold_s: float
    taken: list[Command] = field(default_factory=list)
    released: bool = False

    def hold(self, now_s: float) -> None:
        self.hold_s, self.released = now_s, False

    def hear(
        self, viewer: int, command: Command, present: bool, one_way_s: float, now_s: float
    ) -> None:
        numbers = [command.linear, command.angular, *command.axes.values()]
        rules = [
            viewer == OPERATOR and present,
            command.turn == TURN,
            all(command.seq > other.seq for other in self.taken),
            all(math.isfinite(n) and abs(n) <= 1 for n in numbers),
            now_s - command.sent_s <= self.max_age_s,
            command.sent_s - now_s <= 0.05 + one_way_s,
        ]
        if all(rules):
            self.taken.append(replace(command, sent_s=min(command.sent_s, now_s)))
            if command.linear == command.angular == 0 and self.taken[-1].sent_s >= self.hold_s:
                self.released = True

    def newest(self) -> Command | None:
        """Return the newest command sent since the hold, once that is released."""
        since = [c for c in self.taken if c.sent_s >= self.hold_s]
        return since[-1] if since and self.released else None


@settings(max_examples=400, deadline=None)
@given(st.lists(words, min_size=10, max_size=60), st.sampled_from([0.0, 0.02, 0.2]))
def test_motion_only_by_the_rules(trace: list[Word], one_way_s: float) -> None:
    """Whatever repeats, overtakes, delays or lies: only the newest that keeps all rules moves."""
    now_s, seq, present = 1000.0, 10, True
    state = gate.begin(TURN, now_s)
    max_age_s = SETTINGS.max_age_ms / 1000 + one_way_s
    judge = Judge(max_age_s=max_age_s, hold_s=now_s)
    for word in trace:
        now_s += word.gap_s
        turn = TurnView(number=TURN, operator=OPERATOR, present=present, one_way_s=one_way_s)
        match word.what:
            case "drive":
                seq += 1
                command = Command(
                    seq=seq - word.seq_back,
                    turn=word.turn,
                    sent_s=now_s - word.delay_s,
                    linear=word.hands[0],
                    angular=word.hands[1],
                    speed="fine" if word.speed == "fine" else "gross",
                    axes=word.axes,
                )
                judge.hear(word.viewer, command, present, one_way_s, now_s)
                state, _ = gate.accept(
                    state, word.viewer, command, turn=turn, now_s=now_s, settings=SETTINGS
                )
            case "stop":
                state = gate.require_neutral(state, now_s, Hold.STOPPED)
                judge.hold(now_s)
            case _:
                present = word.what == "return"
        turn = TurnView(number=TURN, operator=OPERATOR, present=present, one_way_s=one_way_s)
        setpoint = gate.decide(state, turn, now_s, SETTINGS, LIMITS)
        twist, newest = setpoint.twist, judge.newest()

        assert abs(twist.linear_mps) <= LIMITS.linear_mps
        assert abs(twist.angular_rps) <= LIMITS.angular_rps
        assert set(setpoint.axes) <= set(LIMITS.axes)
        assert all(abs(position) <= 1 for position in setpoint.axes.values())
        fresh = newest is not None and now_s - newest.sent_s <= max_age_s
        if newest is not None and fresh and present:
            fraction = SETTINGS.fine_fraction if newest.speed == "fine" else 1.0
            assert twist.linear_mps == newest.linear * fraction * LIMITS.linear_mps
            assert twist.angular_rps == newest.angular * fraction * LIMITS.angular_rps
            assert setpoint.reason is None
        else:
            assert twist.is_zero
            assert not setpoint.axes
            assert setpoint.reason


@given(linear=any_share, angular=any_share, pan=any_share, sent_s=st.floats())
def test_no_number_gets_past_the_gate(
    linear: float, angular: float, pan: float, sent_s: float
) -> None:
    """NaN, infinity and what is out of range are refused, and the robot stands."""
    turn = TurnView(number=TURN, operator=OPERATOR, present=True, one_way_s=math.inf)
    state, _ = gate.accept(
        gate.begin(TURN, 0.0),
        OPERATOR,
        Command(1, TURN, 0.5, 0, 0, "gross"),
        turn=turn,
        now_s=0.5,
        settings=SETTINGS,
    )
    wild = Command(2, TURN, sent_s, linear, angular, "gross", axes={"pan": pan})
    state, refusal = gate.accept(state, OPERATOR, wild, turn=turn, now_s=0.5, settings=SETTINGS)
    sound = all(abs(n) <= 1 for n in (linear, angular, pan)) and math.isfinite(sent_s)
    assert sound or refusal is not None
    twist = gate.decide(state, turn, 0.5, SETTINGS, LIMITS).twist
    assert abs(twist.linear_mps) <= LIMITS.linear_mps
    assert abs(twist.angular_rps) <= LIMITS.angular_rps
    assert sound or twist.is_zero
