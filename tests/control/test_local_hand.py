"""The rules of the hand control aboard, one at a time."""

from __future__ import annotations

import math
from dataclasses import astuple, replace
from typing import TYPE_CHECKING, Any

import pytest

from wax.config.local import LocalSettings
from wax.config.robot import RobotSettings
from wax.control import local_hand
from wax.control.local_hand import HandRules, HandState
from wax.driver.hand import HandReading
from wax.driver.interface import STANDSTILL, Aboard, Limits, Twist

if TYPE_CHECKING:
    from wax.driver.interface import Ask, HandMode

LIMITS = Limits(linear_mps=0.8, angular_rps=2.0, lateral_mps=0.4)
RULES = HandRules.of(
    LocalSettings(source="robot", silence_ms=125, pause_s=2.0, dead_zone=0.2, max_fraction=0.5),
    RobotSettings(),
    0.02,
)
SHARING = replace(RULES, shares=True)
REST = (0.0, 0.0)
AHEAD = (1.0, 0.0)


class Person:
    """A person whose control sends a reading every 20 ms."""

    def __init__(self, rules: HandRules = RULES) -> None:
        self.rules = rules
        self.now_s = 100.0
        self.state = HandState()
        self.is_operator_heard = True

    def does(self, stick: tuple[float, float] = REST, **more: Any) -> HandMode:
        """Send one reading, and return the resulting mode."""
        self.now_s += 0.02
        reading = HandReading(self.now_s, *stick, **more)
        self.state = local_hand.accept(
            self.state,
            reading,
            self.now_s,
            self.rules,
            is_operator_heard=self.is_operator_heard,
        )
        return self.state.mode

    def goes_on(self, during_s: float, stick: tuple[float, float] = REST) -> HandMode:
        """Repeat a reading for a while."""
        until_s = self.now_s + during_s
        while self.now_s < until_s:
            self.does(stick)
        return self.state.mode

    def silent(self, during_s: float) -> HandMode:
        self.now_s += during_s
        self.state = local_hand.tick(self.state, self.now_s, self.rules)
        return self.state.mode

    def press(self, ask: Ask) -> HandMode:
        self.does(ask=ask)
        return self.does()

    @property
    def twist(self) -> Twist:
        return local_hand.twist(self.state, self.rules, LIMITS)

    @property
    def speeds(self) -> tuple[float, float]:
        """Their speeds ahead and turning, rounded to what anybody could feel."""
        return round(self.twist.linear_mps, 6), round(self.twist.angular_rps, 6)

    @property
    def share(self) -> float:
        return local_hand.share(self.state, self.rules)


def sitting(rules: HandRules = RULES) -> Person:
    """Return a person who lets an operator drive."""
    person = Person(rules)
    assert person.goes_on(2.1) == "free"
    return person


def test_nobody_drives_before_the_control_was_heard() -> None:
    """Before its first reading the control counts as lost."""
    person = Person()
    assert person.state.mode == "lost"
    assert person.silent(1000.0) == "lost"
    assert (person.twist, person.share) == (STANDSTILL, 0.0)


def test_at_rest_an_operator_may_drive_after_the_pause() -> None:
    """The first reading starts the pause, after which an operator may drive."""
    person = Person()
    assert person.does() == "pause"
    assert person.goes_on(1.9) == "pause"
    assert person.goes_on(0.2) == "free"
    assert (person.twist, person.share) == (STANDSTILL, 1.0)


@pytest.mark.parametrize("stick", [(0.21, 0.0), (-0.21, 0.0), (0.0, 0.3), (0.0, -1.0)])
def test_a_touch_takes_over_at_once(stick: tuple[float, float]) -> None:
    """One reading beyond the dead zone in any direction takes over from the operator."""
    person = sitting()
    assert person.does(stick) == "hand"
    assert person.share == 0.0
    assert not person.twist.is_zero
    assert sitting().does(lateral=sum(stick)) == "hand"


def test_a_hand_that_is_felt_takes_over_too() -> None:
    """A sensed hand takes over even with the stick at rest; the robot then stands."""
    person = sitting()
    assert person.does(is_held=True) == "hand"
    assert (person.twist, person.share) == (STANDSTILL, 0.0)


def test_within_the_dead_zone_nothing_is_touched() -> None:
    """A stick that does not quite return to its middle leaves the operator alone."""
    person = sitting()
    assert person.does((0.2, -0.2), lateral=-0.2) == "free"


def test_the_set_point_grows_from_the_dead_zone_to_the_persons_most() -> None:
    """The dead zone's edge is standstill, full deflection the person's fraction of the speed.

    A diagonal is no faster.
    """
    person = sitting()
    person.does((0.6, 0.0))
    assert person.speeds == (0.2, 0.0)
    person.does((-1.0, 0.0))
    assert person.speeds == (-0.4, 0.0)
    person.does((0.0, 1.0))
    assert person.speeds == (0.0, 1.0)
    person.does(lateral=-0.6)
    assert astuple(person.twist) == pytest.approx((0.0, 0.0, -0.1))
    person.does((1.0, 0.0), lateral=1.0)
    assert person.speeds == (round(0.4 / math.sqrt(2), 6), 0.0)
    assert person.twist.lateral_mps == pytest.approx(0.2 / math.sqrt(2))


def test_letting_go_gives_back_after_a_pause() -> None:
    """The robot stands for the whole pause, counted from the last touch."""
    person = sitting()
    person.goes_on(1.0, AHEAD)
    assert person.does() == "pause"
    assert (person.twist, person.share) == (STANDSTILL, 0.0)
    assert person.goes_on(1.0) == "pause"
    assert person.does(AHEAD) == "hand"
    assert person.does() == "pause"
    assert person.goes_on(1.9) == "pause"
    assert person.goes_on(0.2) == "free"


def test_stop_holds_everybody_until_they_go_on() -> None:
    """Neither time nor the stick releases a Stop, only a request with the stick at rest."""
    person = sitting()
    assert person.does(stop=True) == "stopped"
    assert person.does() == "stopped"
    assert person.goes_on(60.0) == "stopped"
    assert person.does(AHEAD) == "stopped"
    assert (person.twist, person.share) == (STANDSTILL, 0.0)
    assert person.does(AHEAD, ask="go_on") == "stopped"
    assert person.does(AHEAD) == "stopped"
    assert person.does(stop=True, ask="go_on") == "stopped"
    person.does()
    assert person.does(ask="go_on") == "pause"
    assert person.goes_on(2.1) == "free"


def test_stop_ends_their_own_driving() -> None:
    """Stop outranks a hand on the stick, which must then be released first."""
    person = sitting()
    person.goes_on(0.5, AHEAD)
    assert person.does(AHEAD, stop=True) == "stopped"
    assert person.twist == STANDSTILL
    person.does()
    assert person.press("go_on") == "pause"
    assert person.does(AHEAD) == "hand"


def test_a_button_that_hangs_releases_nothing() -> None:
    """A button down since before Stop or a reconnection is no request to resume."""
    person = sitting()
    person.does(ask="go_on")
    person.does(ask="go_on", stop=True)
    assert person.does(ask="go_on") == "stopped"
    assert person.silent(0.2) == "lost"
    assert person.does(ask="go_on") == "stopped"
    assert person.does(ask="go_on") == "stopped"
    assert person.press("go_on") == "stopped"  # it was down throughout
    assert person.press("go_on") == "pause"


def test_silence_holds_everybody() -> None:
    """The timeout is exact, and a control that is back starts with the pause."""
    person = sitting()
    person.goes_on(0.1, AHEAD)
    assert person.silent(0.124) == "hand"
    assert person.silent(0.002) == "lost"
    assert (person.twist, person.share) == (STANDSTILL, 0.0)
    assert person.does() == "pause"


def test_a_stop_outlasts_silence() -> None:
    """Unplugging the control and plugging it in again does not release the Stop."""
    person = sitting()
    person.does(stop=True)
    assert person.silent(1.0) == "lost"
    assert person.does() == "stopped"


def test_a_stick_that_is_held_throughout_moves_nothing() -> None:
    """After a start or a loss the control must be at rest before it drives."""
    person = Person()
    assert person.goes_on(10.0, AHEAD) == "pause"
    assert person.twist == STANDSTILL
    person.does()
    assert person.does(AHEAD) == "hand"
    person.silent(0.2)
    assert person.goes_on(10.0, AHEAD) == "pause"


def test_after_a_fault_the_control_must_be_seen_at_rest() -> None:
    """A hand on the stick when the robot reconnects does not move it."""
    person = sitting()
    person.goes_on(0.1, AHEAD)
    person.state = local_hand.disarm(person.state, person.now_s)
    assert person.state.mode == "pause"
    assert person.does(AHEAD) == "pause"
    person.does()
    assert person.does(AHEAD) == "hand"


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf, 1.01, -1.01])
def test_a_number_out_of_range_is_a_lost_control(number: float) -> None:
    """An impossible reading counts as a lost control, and the robot stands."""
    for stick in ((number, 0.0), (0.0, number)):
        person = sitting()
        assert person.does(stick) == "lost"
    assert sitting().does(lateral=number) == "lost"


@pytest.mark.parametrize("age_s", [0.125, 0.2, -0.001])
def test_old_readings_and_those_of_the_future_count_as_none(age_s: float) -> None:
    """Old and future readings neither take over nor end the silence."""
    person = sitting()
    reading = HandReading(person.now_s - age_s, 1.0)
    after = local_hand.accept(person.state, reading, person.now_s, RULES)
    assert after == person.state


@pytest.mark.parametrize("age_s", [0.125, 60.0, -0.001])
def test_a_stop_counts_however_late_it_comes(age_s: float) -> None:
    """A Stop counts even if it was buffered, or is older than the newest reading."""
    person = sitting()
    person.does(AHEAD)
    press = HandReading(person.now_s - age_s, stop=True)
    person.state = local_hand.accept(person.state, press, person.now_s, RULES)
    assert person.state.mode == "stopped"
    assert person.goes_on(3.0) == "stopped"


@pytest.mark.parametrize("stick", [(math.nan, 0.0), (0.0, 1.01)])
def test_a_stop_counts_whatever_is_wrong_with_the_stick(stick: tuple[float, float]) -> None:
    """An impossible stick value loses the control, but its Stop is in force when it is back."""
    person = sitting()
    assert person.does(stick, stop=True) == "lost"
    assert person.does() == "stopped"


def test_a_stop_does_not_bring_a_lost_control_back() -> None:
    """An old Stop does not make a lost control count as present."""
    person = sitting()
    person.silent(1.0)
    press = HandReading(person.now_s - 0.5, stop=True)
    person.state = local_hand.accept(person.state, press, person.now_s, RULES)
    assert person.state.mode == "lost"
    assert person.does() == "stopped"


def test_an_earlier_reading_does_not_count_after_a_later_one() -> None:
    """Of two readings in the wrong order, the later one counts."""
    person = sitting()
    person.does()
    before = HandReading(person.now_s - 0.01, 1.0)
    assert local_hand.accept(person.state, before, person.now_s, RULES) == person.state


def test_several_readings_of_one_moment_all_count() -> None:
    """Of buffered readings with one timestamp, the last gives the control's state."""
    person = sitting()
    for stick in (AHEAD, REST):
        reading = HandReading(person.now_s, *stick)
        person.state = local_hand.accept(person.state, reading, person.now_s, RULES)
    assert person.state.mode == "pause"


def test_requests_are_numbered_by_their_presses() -> None:
    """Each press is one request, however long it is held, and the newest request is reported."""
    person = sitting()
    for _ in range(5):
        person.does(ask="left")
    person.press("wait")
    person.press("wait")
    assert local_hand.report(person.state, RULES) == Aboard("free", 1.0, "wait", 3)


def test_a_request_does_not_touch() -> None:
    """A request does not take over from the operator."""
    person = sitting()
    assert person.press("right") == "free"


def test_sharing_passes_as_much_as_the_stick_is_ahead() -> None:
    """A shared stick lets through as much as it is pushed ahead, and never takes over."""
    person = sitting(SHARING)
    assert person.share == 0.0
    for stick, share in [
        ((0.6, 0.0), 0.5),
        ((1.0, 0.0), 1.0),
        ((-1.0, 0.0), 0.0),
        ((0.0, 1.0), 0.0),
    ]:
        assert person.does(stick) == "free"
        assert person.share == pytest.approx(share)
        assert person.twist == STANDSTILL
    assert person.does(lateral=1.0) == "free"
    assert person.share == 0.0


def test_alone_the_sharing_stick_drives_once_it_was_at_rest() -> None:
    """Without an operator the shared stick drives, but only after it has been at rest."""
    person = sitting(SHARING)
    person.does(AHEAD)
    person.is_operator_heard = False
    assert person.goes_on(5.0, AHEAD) == "pause"
    assert (person.twist, person.share) == (STANDSTILL, 0.0)
    person.does()
    assert person.does(AHEAD) == "hand"
    assert person.speeds == (0.4, 0.0)


def test_an_operator_who_is_back_does_not_take_the_stick_out_of_the_hand() -> None:
    """A person who drives alone keeps driving until they let go; sharing starts after the pause."""
    person = sitting(SHARING)
    person.is_operator_heard = False
    person.does()
    assert person.does(AHEAD) == "hand"
    person.is_operator_heard = True
    assert person.goes_on(1.0, AHEAD) == "hand"
    assert person.does() == "pause"
    assert person.goes_on(2.1) == "free"
    assert person.does(AHEAD) == "free"
