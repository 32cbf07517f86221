"""Properties of the hand control aboard, for any readings at any time."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.control.velocity import fraction
from tests.examples import examples

from wax.config.local import LocalSettings
from wax.config.robot import RobotSettings
from wax.control import local_hand
from wax.control.local_hand import HandRules, HandState
from wax.driver.hand import HandReading
from wax.driver.interface import STANDSTILL, Limits, Twist

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.driver.interface import Ask

LIMITS = Limits(linear_mps=0.8, angular_rps=2.0, lateral_mps=0.4)
DRIVES = HandRules.of(
    LocalSettings(source="robot", silence_ms=125, pause_s=0.5, dead_zone=0.2, max_fraction=0.5),
    RobotSettings(),
    0.02,
)
RULES = (DRIVES, replace(DRIVES, shares=True))


@dataclass(frozen=True)
class Word:
    """A reading, how often it is repeated, at what interval, and how late it arrives."""

    times: int
    linear: float
    ask: Ask | None
    is_operator_heard: bool
    what: str = "say"
    gap_s: float = 0.02
    late_s: float = 0.0
    angular: float = 0.0
    lateral: float = 0.0
    is_held: bool = False
    stop: bool = False


def each(**choices: list[Any]) -> st.SearchStrategy[dict[str, Any]]:
    """Draw from every list at once, which is much faster than one by one."""
    every = product(*choices.values())
    return st.sampled_from([dict(zip(choices, one, strict=True)) for one in every])


shares = st.sampled_from([0.0] * 8 + [0.2, 0.21, 1.0, -1.0, 1.01, math.nan])
sticks = st.one_of(shares, st.floats(-1.0, 1.0))
words = st.builds(
    lambda when, how, who, linear, angular, lateral: Word(
        **when, **how, **who, linear=linear, angular=angular, lateral=lateral
    ),
    each(
        what=["say"] * 12 + ["wait", "lose", "disarm"],
        times=[1, 2, 30],
        gap_s=[0.02] * 6 + [0.0, 0.124, 0.126],
    ),
    each(
        late_s=[0.0] * 6 + [0.01, 0.124, 0.126, 1.0, -0.01],
        is_held=[False] * 7 + [True],
        stop=[False] * 9 + [True],
    ),
    each(ask=[None, None, None, "go_on", "go_on", "left"], is_operator_heard=[True, True, False]),
    sticks,
    sticks,
    sticks,
)
calm = each(
    times=[2, 30],
    linear=[0.0, 0.0, 0.0, 0.5, 1.0],
    ask=[None, None, "go_on"],
    is_operator_heard=[False, True],
).map(lambda one: Word(**one))
"""Without this, hardly a trace would get anybody to drive."""
traces = st.lists(st.one_of(calm, words), max_size=25)


class Judge:
    """Decides who may move the robot; it knows no modes, only the readings and their times."""

    def __init__(self, rules: HandRules) -> None:
        self.rules = rules
        self.newest: HandReading | None = None
        self.not_free_s = -math.inf
        """When an operator last could not drive."""
        self.is_stopped = False
        self.was_at_rest = False

    def hear(self, reading: HandReading, now_s: float, *, is_operator_heard: bool) -> None:
        self.is_stopped = self.is_stopped or reading.stop
        before = self.newest
        if before is not None and reading.at_s < before.at_s:
            return
        if not 0.0 <= now_s - reading.at_s < self.rules.silence_s:
            return
        if not reading.is_in_range:
            self.lose()
            return
        self.newest = reading
        is_touched = local_hand.touches(reading, self.rules)
        if before is not None and before.ask != "go_on" == reading.ask and not is_touched:
            self.is_stopped = reading.stop
        self.was_at_rest = self.was_at_rest or not is_touched
        if is_touched and not (self.rules.shares and is_operator_heard):
            self.not_free_s = now_s

    def lose(self) -> None:
        self.newest, self.was_at_rest = None, False

    def look(self, now_s: float) -> None:
        if self.newest is not None and not now_s - self.newest.at_s < self.rules.silence_s:
            self.lose()
        if self.newest is None or self.is_stopped:
            self.not_free_s = now_s

    def allows(self, twist: Twist, share: float, now_s: float) -> bool:
        self.look(now_s)
        if twist == STANDSTILL and share == 0.0:
            return True
        if self.newest is None or self.is_stopped:
            return False
        if share > 0.0:
            return twist == STANDSTILL and self._leaves(share, now_s)
        return self.was_at_rest and self._points(twist)

    def _leaves(self, share: float, now_s: float) -> bool:
        """Whether this share of an operator's set-point may pass."""
        assert self.newest is not None
        most = max(0.0, self.newest.linear) if self.rules.shares else 1.0
        return now_s - self.not_free_s >= self.rules.pause_s and share <= most

    def _points(self, twist: Twist) -> bool:
        """Whether the person's stick asks for this twist, within their speed."""
        assert self.newest is not None
        most = self.rules.max_fraction
        is_touched = local_hand.touches(self.newest, self.rules)
        is_in_their_limit = fraction(twist, LIMITS) <= most * (1 + 1e-9)
        return (
            is_touched
            and is_in_their_limit
            and all(
                part * stick >= 0.0 and abs(part) <= abs(stick) * fast * most
                for part, stick, fast in (
                    (twist.linear_mps, self.newest.linear, LIMITS.linear_mps),
                    (twist.angular_rps, self.newest.angular, LIMITS.angular_rps),
                    (twist.lateral_mps, self.newest.lateral, LIMITS.lateral_mps),
                )
            )
        )


def play(
    trace: list[Word], rules: HandRules, each: Callable[[HandState, Judge, float], None]
) -> None:
    """Give the same readings to the rules and the judge, and yield both after each."""
    state, judge, now_s = HandState(), Judge(rules), 100.0
    for word in trace:
        for _ in range(word.times):
            now_s += word.gap_s
            judge.look(now_s)
            match word.what:
                case "say":
                    reading = HandReading(
                        now_s - word.late_s,
                        word.linear,
                        word.angular,
                        word.is_held,
                        word.stop,
                        word.ask,
                        word.lateral,
                    )
                    heard = word.is_operator_heard
                    state = local_hand.accept(state, reading, now_s, rules, is_operator_heard=heard)
                    judge.hear(reading, now_s, is_operator_heard=heard)
                case "lose":
                    state = local_hand.lose(state)
                    judge.lose()
                case "disarm":
                    state = local_hand.disarm(state, now_s)
                    judge.was_at_rest = False
            state = local_hand.tick(state, now_s, rules)
            each(state, judge, now_s)


@pytest.mark.timeout(300)  # it computes for ten seconds on a quiet machine
@examples(4000)
@given(traces, st.sampled_from(RULES))
def test_whoever_moves_the_robot_has_the_right_to(trace: list[Word], rules: HandRules) -> None:
    """An operator moves the robot only after a full pause, the person by their newest reading."""

    def each(state: HandState, judge: Judge, now_s: float) -> None:
        twist, share = local_hand.twist(state, rules, LIMITS), local_hand.share(state, rules)
        assert judge.allows(twist, share, now_s), (twist, share, state)
        assert state.is_stopped is judge.is_stopped

    play(trace, rules, each)
