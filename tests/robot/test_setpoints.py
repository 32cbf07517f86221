"""Which set-point a serial robot may follow now."""

from __future__ import annotations

import math

import pytest
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule
from tests.examples import examples

from wax.driver.interface import STANDSTILL, Limits, Twist
from wax.robot.line.setpoints import Order, SetPoints

LIMITS = Limits(0.6, 1.5, axes=("pan",))
AHEAD = Twist(0.5, 0.0)
TTL_S = 0.2


def ready() -> SetPoints:
    """Return set-points of a connected line, with standstill at time 0."""
    setpoints = SetPoints(LIMITS, TTL_S)
    setpoints.connected()
    setpoints.apply(STANDSTILL, 0, 0.0)
    return setpoints


def wanted(setpoints: SetPoints, now_s: float) -> Twist:
    return setpoints.order(now_s)[0].twist


def test_the_newest_counts_until_it_is_too_old() -> None:
    """A set-point is followed for its time-to-live, whose end is returned with it."""
    setpoints = ready()
    setpoints.apply(AHEAD, 1, 10.0)
    assert setpoints.order(10.1) == (Order(AHEAD, 1), 10.2)
    assert setpoints.order(10.2) == (Order(STANDSTILL, 1), math.inf)


@pytest.mark.parametrize("is_noticed", [True, False])
def test_expired_motion_resumes_only_after_standstill(is_noticed: bool) -> None:
    """Motion after an expiry, as from a process that was frozen, moves nothing."""
    setpoints = ready()
    setpoints.apply(AHEAD, 1, 10.0)
    if is_noticed:
        setpoints.order(10.5)
    setpoints.apply(AHEAD, 1, 11.0)
    setpoints.apply(AHEAD, 1, 11.1)
    assert wanted(setpoints, 11.1) == STANDSTILL
    setpoints.apply(STANDSTILL, 1, 11.2)
    setpoints.apply(AHEAD, 1, 11.3)
    assert wanted(setpoints, 11.3) == AHEAD


def test_the_past_turn_is_over() -> None:
    """An earlier turn moves nothing, not even an axis; a later one begins at standstill."""
    setpoints = ready()
    setpoints.apply(AHEAD, 5, 1.0)
    setpoints.apply(Twist(-0.5, 0.0), 4, 1.0)
    setpoints.set_axis("pan", 1.0, 4)
    assert setpoints.order(1.1)[0] == Order(AHEAD, 5)
    setpoints.set_axis("pan", 2.0, 6)
    assert setpoints.order(1.1)[0] == Order(STANDSTILL, 6, (("pan", 1.0),))


def test_stop_is_never_refused() -> None:
    """A stop of any turn stops; an old one revives no turn, a new one ends the last."""
    setpoints = ready()
    setpoints.apply(AHEAD, 5, 1.0)
    setpoints.stop(2)
    assert wanted(setpoints, 1.1) == STANDSTILL
    setpoints.apply(AHEAD, 4, 1.1)
    assert wanted(setpoints, 1.1) == STANDSTILL
    setpoints.apply(AHEAD, 5, 1.1)
    assert wanted(setpoints, 1.1) == AHEAD
    setpoints.stop(6)
    setpoints.apply(AHEAD, 5, 1.2)
    assert setpoints.order(1.2)[0] == Order(STANDSTILL, 6)


@pytest.mark.parametrize("neutral", ["apply", "stop"])
def test_after_a_loss_it_takes_neutral_and_then_motion(neutral: str) -> None:
    """Motion that continues across a loss is refused until there was standstill."""
    setpoints = ready()
    setpoints.apply(AHEAD, 1, 1.0)
    setpoints.set_axis("pan", 0.5, 1)
    setpoints.lost()
    setpoints.stop(1)
    setpoints.apply(STANDSTILL, 1, 1.05)
    setpoints.connected()
    setpoints.apply(AHEAD, 1, 1.1)
    assert setpoints.order(1.1)[0] == Order(STANDSTILL, 1)
    if neutral == "apply":
        setpoints.apply(STANDSTILL, 1, 1.2)
    else:
        setpoints.stop(1)
    assert wanted(setpoints, 1.2) == STANDSTILL
    setpoints.apply(AHEAD, 1, 1.3)
    assert wanted(setpoints, 1.3) == AHEAD


def test_before_the_first_call_it_stands() -> None:
    """There is no turn, no motion and no axis."""
    assert SetPoints(LIMITS, TTL_S).order(0.0) == (Order(STANDSTILL, 0), math.inf)


def test_an_axis_does_not_end_the_motion() -> None:
    """Within a turn, the camera can turn while the robot drives."""
    setpoints = ready()
    setpoints.apply(AHEAD, 1, 1.0)
    setpoints.set_axis("pan", 0.5, 1)
    assert setpoints.order(1.1)[0] == Order(AHEAD, 1, (("pan", 0.5),))


def test_no_axis_is_set_without_a_line() -> None:
    """An axis set while the line is lost is ignored."""
    setpoints = ready()
    setpoints.lost()
    setpoints.set_axis("pan", 0.5, 1)
    assert setpoints.order(0.0)[0].axes == ()


def test_an_unknown_axis_is_ignored() -> None:
    """Only the axes of the limits are moved."""
    setpoints = ready()
    setpoints.set_axis("jaw", 1.0, 1)
    assert setpoints.order(0.0)[0].axes == ()


class Histories(RuleBasedStateMachine):
    """Any sequence of calls, losses and pauses."""

    def __init__(self) -> None:
        super().__init__()
        self.setpoints = SetPoints(LIMITS, TTL_S)
        self.now_s = 0.0
        self.online = self.neutral = False
        self.highest = -1
        self.applied_s = -math.inf

    @rule(linear=st.sampled_from([0.0, 0.5, -9.0]), turn=st.integers(0, 3))
    def apply(self, linear: float, turn: int) -> None:
        self.setpoints.apply(Twist(linear, 0.0), turn, self.now_s)
        if turn >= self.highest:
            self.highest = turn
            self.applied_s = self.now_s
            self.neutral = self.neutral or (self.online and linear == 0.0)

    @rule(turn=st.integers(0, 3))
    def stop(self, turn: int) -> None:
        self.setpoints.stop(turn)
        self.highest = max(self.highest, turn)
        self.neutral = self.online
        assert self.setpoints.order(self.now_s)[0].twist == STANDSTILL

    @rule()
    def connect(self) -> None:
        self.setpoints.connected()
        self.online, self.neutral = True, False

    @rule()
    def lose(self) -> None:
        self.setpoints.lost()
        self.online = self.neutral = False

    @rule(pause_s=st.sampled_from([0.01, 0.1, 0.3]))
    def wait(self, pause_s: float) -> None:
        moved = not self.setpoints.order(self.now_s)[0].twist.is_zero
        self.now_s += pause_s
        if moved and self.now_s - self.applied_s >= TTL_S:
            self.neutral = False

    @invariant()
    def motion_has_every_right(self) -> None:
        order, _ = self.setpoints.order(self.now_s)
        if not order.twist.is_zero:
            assert self.online
            assert self.neutral
            assert order.turn == self.highest
            assert self.now_s - self.applied_s < TTL_S
            assert abs(order.twist.linear_mps) <= LIMITS.linear_mps


TestHistories = Histories.TestCase
TestHistories.settings = examples(150, stateful_step_count=30)
TestHistories.__doc__ = (
    "Motion is always of the newest turn, fresh, and after a neutral since the last expiry."
)
