"""How well a picture's age is known, and what the gate does if it is not."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from tests.control.rules import RULES, VOUCHED

from wax.control import gate
from wax.control.command import Command
from wax.control.picture_clock import PictureClock
from wax.control.reasons import Refusal
from wax.control.turn_view import TurnView
from wax.control.video_freshness import VideoFreshness, judge

TURN = TurnView(number=1, operator=1, present=True, one_way_s=0.0, sees=True, picture=VOUCHED)


@pytest.mark.parametrize("within_s", [None, math.nan, math.inf, -0.1])
def test_an_unknown_error_is_an_unknown_age(within_s: float | None) -> None:
    """Without a valid error bound no picture's age is known, not even an earlier one's."""
    clock = PictureClock().after(5.0, 0.1).after(5.1, within_s)
    assert clock.doubted_s == 5.1
    turn = replace(TURN, picture=clock)
    assert judge(5.1, 5.1, turn, RULES) is VideoFreshness.NONE
    assert judge(5.0, 5.0, turn, RULES) is VideoFreshness.NONE


def test_a_clock_that_errs_by_nothing_adds_no_age() -> None:
    """An error bound of 0 adds nothing to the reported age."""
    assert judge(5.0, 5.39, TURN, RULES) is VideoFreshness.CLEAR


def test_only_what_was_captured_since_is_known() -> None:
    """Once ages are known again, earlier pictures still count as unknown."""
    clock = PictureClock().after(5.0, None).after(5.1, 0.0).after(5.2, 0.0)
    turn = replace(TURN, picture=clock)
    assert judge(5.09, 5.2, turn, RULES) is VideoFreshness.NONE
    assert judge(5.1, 5.2, turn, RULES) is VideoFreshness.CLEAR


def test_what_a_clock_may_err_by_is_age() -> None:
    """An error bound of 0.3 s makes the robot slow down and stop 0.3 s earlier."""
    clock = PictureClock().after(5.0, 0.3).after(5.1, 0.1)  # the screen may still show the first
    turn = replace(TURN, picture=clock)
    assert judge(5.1, 5.19, turn, RULES) is VideoFreshness.CLEAR
    assert judge(5.1, 5.21, turn, RULES) is VideoFreshness.LATE
    assert judge(5.1, 5.61, turn, RULES) is VideoFreshness.NONE


def test_nobody_starts_and_nobody_goes_on_by_an_unknown_age() -> None:
    """A picture of unknown age stops the robot and prevents starting, with a reason."""
    driving = replace(TURN, picture=PictureClock().after(1.0, 0.0))
    lost = replace(TURN, picture=driving.picture.after(9.9, None))
    neutral = Command(1, 1, 10.0, 0, 0, False, "fast", seen_s=10.0, heard_s=10.0)
    ahead = replace(neutral, seq=2, linear=1, held=True)
    _, refusal = gate.accept(gate.begin(1, 9.0), 1, neutral, turn=lost, now_s=10.0, rules=RULES)
    assert refusal is Refusal.UNDATED
    state = gate.begin(1, 9.0)
    for command in (neutral, ahead):
        state, refusal = gate.accept(state, 1, command, turn=driving, now_s=10.0, rules=RULES)
        assert refusal is None
    state, setpoint = gate.decide(state, driving, None, 10.0, RULES)
    assert setpoint.twist.linear_mps > 0
    _, setpoint = gate.decide(state, lost, None, 10.0, RULES)
    assert setpoint.twist.is_zero
    assert setpoint.reason == Refusal.UNDATED.value


def test_whoever_looks_away_on_purpose_is_not_asked() -> None:
    """With the picture switched off its age does not matter, and the robot is slow."""
    turn = replace(TURN, sees=False, picture=PictureClock())
    assert judge(None, 5.0, turn, RULES) is VideoFreshness.OFF


def test_a_doubt_is_told_once_it_lasts() -> None:
    """Pictures of unknown age are reported only after three seconds."""
    clock = PictureClock()
    assert not clock.is_doubted(100.0)
    clock = clock.after(5.0, None).after(7.0, None)
    assert not clock.is_doubted(8.0)
    assert clock.is_doubted(8.1)
    assert not clock.after(8.1, 0.0).is_doubted(8.2)
