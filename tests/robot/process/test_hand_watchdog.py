"""What the driver process lets through with a person aboard."""

from __future__ import annotations

from dataclasses import astuple, replace
from typing import TYPE_CHECKING, Any

import pytest

from wax.config.controls import ControlSettings
from wax.config.local import LocalSettings
from wax.config.robot import RobotSettings
from wax.control.local_hand import HandRules
from wax.control.reasons import NO_HAND
from wax.driver.checks import NO_ANSWER
from wax.driver.hand import HandReading
from wax.driver.interface import STANDSTILL, Limits, Twist
from wax.robot.process.driver_watchdog import (
    SILENT,
    Apply,
    DriverWatchdog,
    SetAxis,
    SetControl,
    StopDriver,
)
from wax.robot.process.hand_watchdog import HandWatchdog
from wax.robot.process.pipe_messages import Axis, Control, Halt, Move

if TYPE_CHECKING:
    from wax.robot.process.driver_watchdog import Call

LIMITS = Limits(linear_mps=0.6, angular_rps=1.5, axes=("pan",), lateral_mps=0.6)
SILENCE_S = 0.12
RULES = HandRules.of(
    LocalSettings(source="robot", pause_s=1.0, max_fraction=1.0),
    RobotSettings(max_linear_acceleration_mps2=100.0, max_angular_acceleration_rps2=200.0),
    0.02,
)
AHEAD = Twist(0.5, 0.0)
CONTROLS = [
    ControlSettings(name="lamp", kind="toggle", roles=["observer"]),
    ControlSettings(name="lift", kind="button", moves=True),
]


class Chair:
    """A server that drives, a person with a control, and an obedient driver."""

    def __init__(self, rules: HandRules = RULES) -> None:
        self.watchdog = HandWatchdog(DriverWatchdog(LIMITS, SILENCE_S, CONTROLS), rules)
        self.now_s = 100.0
        self.sequence = 0
        self.turn = 1
        self.is_operated = True
        self.asked: Twist | None = STANDSTILL
        self.stick = (0.0, 0.0)
        self.aside = 0.0
        self.buttons: dict[str, Any] = {}
        self.is_plugged_in = True
        self.twist = STANDSTILL

    def run(self, during_s: float) -> list[Call]:
        """Let everybody continue for a while, and return the driver's calls."""
        until_s = self.now_s + during_s - 1e-9
        calls: list[Call] = []
        while self.now_s < until_s:
            self.now_s += 0.01
            calls += self.feel()
            calls += self.do(self.watchdog.tick(self.now_s))
            if self.asked is not None:
                calls += self.say(self.asked)
            calls += self.do(self.watchdog.repeat(self.now_s))
        return calls

    def feel(self) -> tuple[Call, ...]:
        reading = HandReading(self.now_s, *self.stick, **self.buttons, lateral=self.aside)
        return self.do(
            self.watchdog.handle_readings([reading] if self.is_plugged_in else [], self.now_s)
        )

    def say(self, twist: Twist) -> tuple[Call, ...]:
        self.sequence += 1
        move = Move(
            sequence=self.sequence,
            sent_s=self.now_s,
            turn=self.turn,
            linear_mps=twist.linear_mps,
            angular_rps=twist.angular_rps,
            lateral_mps=twist.lateral_mps,
            operated=self.is_operated,
        )
        return self.do(self.watchdog.handle(move, self.now_s))

    def control(self, name: str, value: bool) -> tuple[Call, ...]:
        self.sequence += 1
        control = Control(
            sequence=self.sequence, sent_s=self.now_s, turn=self.turn, name=name, value=value
        )
        return self.do(self.watchdog.handle(control, self.now_s))

    def axis(self, position: float) -> tuple[Call, ...]:
        self.sequence += 1
        axis = Axis(
            sequence=self.sequence, sent_s=self.now_s, turn=self.turn, name="pan", position=position
        )
        return self.do(self.watchdog.handle(axis, self.now_s))

    def halt(self) -> tuple[Call, ...]:
        self.sequence += 1
        halt = Halt(sequence=self.sequence, sent_s=self.now_s, turn=self.turn)
        return self.do(self.watchdog.handle(halt, self.now_s))

    def do(self, calls: tuple[Call, ...]) -> tuple[Call, ...]:
        for call in calls:
            if isinstance(call, Apply):
                self.twist = call.twist
            elif isinstance(call, StopDriver):
                self.twist = STANDSTILL
        return calls

    @property
    def mode(self) -> str:
        return self.watchdog.aboard.mode


def driven(rules: HandRules = RULES) -> Chair:
    """Return a chair that an operator drives ahead."""
    chair = Chair(rules)
    chair.run(1.2)
    assert chair.mode == "free"
    chair.asked = AHEAD
    chair.run(0.1)
    assert chair.twist == AHEAD
    return chair


def test_without_a_control_nothing_moves() -> None:
    """Before the control's first reading a server moves nothing, and a problem says why."""
    chair = Chair()
    chair.is_plugged_in = False
    chair.run(0.1)
    chair.asked = AHEAD
    calls = chair.run(1.0)
    assert all(call.twist == STANDSTILL for call in calls if isinstance(call, Apply))
    assert chair.watchdog.problem == NO_HAND


def test_with_the_control_at_rest_it_is_as_without() -> None:
    """With the control at rest set-points, axes, stops and silence work as without a person."""
    chair = driven()
    assert chair.say(AHEAD) == (Apply(AHEAD, 1),)
    assert chair.watchdog.silent_at_s == pytest.approx(chair.now_s + SILENCE_S)
    assert chair.axis(0.5) == (SetAxis("pan", 0.5, 1),)
    assert chair.halt() == (StopDriver(1),)


def test_a_touch_stops_on_the_event_and_drives_from_the_next_beat() -> None:
    """A touch stops the robot at once, and the person drives from the next tick."""
    chair = driven()
    chair.stick = (0.0, 1.0)
    chair.now_s += 0.001
    assert chair.feel() == (StopDriver(1),)
    assert chair.mode == "hand"
    assert chair.say(AHEAD) == ()
    calls = chair.run(0.5)
    assert all(isinstance(call, Apply) for call in calls)
    assert chair.twist == Twist(0.0, 1.5)
    assert chair.watchdog.counts["driver_hand_takes"] == 1


def test_a_touch_sideways_is_a_touch() -> None:
    """A stick moved sideways takes over and drives there, a diagonal no faster than ahead."""
    chair = driven()
    chair.aside = -1.0
    assert chair.feel() == (StopDriver(1),)
    chair.run(0.5)
    assert (chair.mode, chair.twist) == ("hand", Twist(0.0, 0.0, -0.6))
    chair.stick = (1.0, 0.0)
    chair.run(0.5)
    assert chair.twist.speed_mps == pytest.approx(0.6)
    assert chair.twist.linear_mps == pytest.approx(-chair.twist.lateral_mps)


def test_an_operator_needs_neutral_after_the_hand() -> None:
    """An operator who asks for motion throughout does not drive when the person lets go."""
    chair = driven()
    chair.stick = (1.0, 0.0)
    chair.run(0.5)
    chair.stick = (0.0, 0.0)
    chair.run(3.0)
    assert (chair.mode, chair.twist) == ("free", STANDSTILL)
    chair.asked = STANDSTILL
    chair.run(0.05)
    chair.asked = AHEAD
    chair.run(0.05)
    assert chair.twist == AHEAD


def test_neutral_within_the_pause_does_not_count() -> None:
    """Standstill that the operator sent during the pause does not count after it."""
    chair = driven()
    chair.stick = (1.0, 0.0)
    chair.run(0.1)
    chair.stick = (0.0, 0.0)
    chair.asked = STANDSTILL
    chair.run(0.5)
    assert chair.mode == "pause"
    chair.asked = AHEAD
    chair.run(2.0)
    assert (chair.mode, chair.twist) == ("free", STANDSTILL)


def test_the_person_drives_on_without_a_server() -> None:
    """The server's silence, stop, invalid message or new turn does not end the person's driving."""
    chair = driven()
    chair.stick = (-1.0, 0.0)
    chair.run(0.1)
    chair.turn = 2
    assert chair.halt() == ()
    chair.do(chair.watchdog.handle_invalid(chair.now_s))
    chair.asked = None
    calls = chair.run(60.0)
    assert not any(isinstance(call, StopDriver) for call in calls)
    assert chair.twist == Twist(-0.6, 0.0)
    assert chair.watchdog.problem is None
    chair.buttons = {"stop": True}
    chair.now_s += 0.001
    assert chair.feel() == (StopDriver(2),)
    assert chair.mode == "stopped"
    assert chair.watchdog.counts["driver_hand_stops"] == 1


def test_a_server_that_is_known_to_be_dead_is_not_waited_for() -> None:
    """A dead server's motion ends at once, while the person drives on."""
    chair = driven()
    assert chair.do(chair.watchdog.abandoned(chair.now_s)) == (StopDriver(1),)
    assert chair.watchdog.problem == SILENT
    chair.run(0.5)
    assert chair.twist == STANDSTILL
    chair = driven()
    chair.stick = (1.0, 0.0)
    chair.run(0.1)
    assert chair.watchdog.abandoned(chair.now_s) == ()
    assert chair.twist == Twist(0.6, 0.0)


def test_a_stop_from_before_this_process_is_in_force() -> None:
    """A Stop from before this process is in force until the person asks to resume."""
    chair = Chair()
    chair.watchdog.recall_stop()
    assert (chair.mode, chair.watchdog.is_stopped) == ("lost", True)
    chair.run(5.0)
    assert (chair.mode, chair.watchdog.is_stopped) == ("stopped", True)
    chair.buttons = {"ask": "go_on"}
    chair.run(0.05)
    assert (chair.mode, chair.watchdog.is_stopped) == ("pause", False)


def test_letting_go_stops_on_the_event() -> None:
    """The robot stops as soon as the person lets go."""
    chair = driven()
    chair.stick = (1.0, 0.0)
    chair.run(0.5)
    chair.stick = (0.0, 0.0)
    chair.now_s += 0.001
    assert chair.feel() == (StopDriver(1),)
    assert all(call.twist == STANDSTILL for call in chair.run(0.5) if isinstance(call, Apply))


def test_a_chair_that_brakes_softly_slows_down_when_it_is_let_go() -> None:
    """With soft braking the chair slows down gently after release, but stops at once at a Stop."""
    chair = driven(replace(RULES, soft_braking=True, braking_mps2=1.0))
    chair.stick = (1.0, 0.0)
    chair.run(1.0)
    assert chair.twist == Twist(0.6, 0.0)
    assert chair.watchdog.is_in_use
    chair.stick = (0.0, 0.0)
    chair.run(0.3)
    assert 0.25 < chair.twist.linear_mps < 0.35
    assert chair.watchdog.is_in_use
    chair.run(0.4)
    assert chair.twist == STANDSTILL
    assert not chair.watchdog.is_in_use
    chair.stick = (1.0, 0.0)
    chair.run(1.0)
    chair.buttons = {"stop": True}
    chair.feel()
    assert chair.twist == STANDSTILL


def test_the_persons_speed_grows_at_the_robots_rate() -> None:
    """The person's own speed rises at the robot's acceleration."""
    chair = driven(replace(RULES, acceleration_mps2=1.0))
    chair.stick = (1.0, 0.0)
    chair.run(0.3)
    assert 0.2 < chair.twist.linear_mps < 0.35
    chair.run(0.5)
    assert chair.twist == Twist(0.6, 0.0)


@pytest.mark.parametrize("touches", [False, True])
def test_a_lost_control_stops_whoever_drives(touches: bool) -> None:
    """A silent or lost control stops both operator and person."""
    for is_known in (False, True):
        chair = driven()
        chair.stick = (float(touches), 0.0)
        chair.run(0.1)
        assert chair.twist != STANDSTILL
        chair.is_plugged_in = False
        if is_known:
            assert chair.do(chair.watchdog.lose_hand(chair.now_s)) == (StopDriver(1),)
        else:
            chair.run(0.16)
        assert (chair.mode, chair.twist) == ("lost", STANDSTILL)
        assert chair.watchdog.problem == NO_HAND
        assert chair.watchdog.counts["driver_hand_losses"] == 1
        chair.run(5.0)
        assert chair.twist == STANDSTILL


def test_a_fault_of_the_robot_holds_the_hand_too() -> None:
    """After a driver's exception or a reconnection the stick must be at rest first."""
    for fault in ("failed", "hold"):
        chair = driven()
        chair.stick = (1.0, 0.0)
        chair.run(0.2)
        watchdog = chair.watchdog
        calls = (
            watchdog.failed(chair.now_s)
            if fault == "failed"
            else watchdog.hold(NO_ANSWER, chair.now_s)
        )
        assert chair.do(calls) == (StopDriver(1),)
        chair.run(1.0)
        assert chair.twist == STANDSTILL
        chair.stick = (0.0, 0.0)
        chair.run(0.05)
        chair.stick = (1.0, 0.0)
        chair.run(0.05)
        assert chair.twist == Twist(0.6, 0.0)


def test_each_change_of_hands_is_a_new_epoch() -> None:
    """Each change of driver raises the epoch, so that the server requires neutral."""
    chair = driven()
    holds = chair.watchdog.holds
    chair.stick = (1.0, 0.0)
    chair.run(0.05)
    assert chair.watchdog.holds > holds
    holds = chair.watchdog.holds
    chair.stick = (0.0, 0.0)
    chair.run(1.5)
    assert chair.watchdog.holds > holds


def test_sharing_scales_and_ramps_what_the_operator_asks() -> None:
    """Sharing scales the operator's set-point by the stick and ramps it at the robot's rate."""
    chair = driven_shared()
    chair.stick = (0.55, 0.0)
    chair.run(0.1)
    assert 0.0 < chair.twist.linear_mps < 0.25
    chair.run(1.0)
    assert chair.twist.linear_mps == pytest.approx(0.25)
    chair.asked = Twist(0.3, 0.2, -0.4)
    chair.run(1.0)
    assert astuple(chair.twist) == pytest.approx((0.15, 0.1, -0.2))
    chair.stick = (0.0, 0.0)
    chair.run(0.02)
    assert chair.twist == STANDSTILL


def test_stops_pass_while_sharing() -> None:
    """The server's stops pass while sharing, and restart the ramp."""
    chair = driven_shared()
    chair.stick = (1.0, 0.0)
    chair.run(1.0)
    assert chair.twist == AHEAD
    assert chair.halt() == (StopDriver(1),)
    calls = chair.say(AHEAD)
    assert isinstance(calls[-1], Apply)
    assert calls[-1].twist.linear_mps < 0.05


def test_without_an_operator_the_sharing_stick_drives() -> None:
    """Without an operator a shared stick drives, once it has been released."""
    chair = driven_shared()
    chair.stick = (1.0, 0.0)
    chair.run(0.5)
    chair.is_operated, chair.asked = False, STANDSTILL
    chair.run(2.0)
    assert (chair.mode, chair.twist) == ("pause", STANDSTILL)
    chair.stick = (0.0, 0.0)
    chair.run(0.05)
    chair.stick = (-1.0, 0.0)
    chair.run(1.0)
    assert (chair.mode, chair.twist) == ("hand", Twist(-0.6, 0.0))


@pytest.mark.parametrize("is_dead", [False, True])
def test_a_sharing_stick_does_not_wait_for_a_server_that_is_not_there(is_dead: bool) -> None:
    """Before the server's first set-point, and once it is known to be dead, the stick drives."""
    chair = driven_shared() if is_dead else Chair(replace(RULES, shares=True))
    if is_dead:
        chair.watchdog.abandoned(chair.now_s)
    chair.asked = None
    chair.run(0.05)
    chair.stick = (1.0, 0.0)
    chair.run(0.05)
    assert chair.mode == "hand"


def test_an_operator_who_comes_does_not_take_the_stick_out_of_the_hand() -> None:
    """Sharing with a new operator starts only after the person has let go and the pause."""
    chair = driven_shared()
    chair.is_operated, chair.asked = False, STANDSTILL
    chair.run(0.1)
    chair.stick = (1.0, 0.0)
    chair.run(1.0)
    chair.is_operated = True
    chair.run(1.0)
    assert (chair.mode, chair.twist) == ("hand", Twist(0.6, 0.0))
    chair.stick = (0.0, 0.0)
    chair.run(1.1)
    chair.stick = (1.0, 0.0)
    chair.run(0.5)
    assert (chair.mode, chair.twist) == ("free", STANDSTILL)


def driven_shared() -> Chair:
    """Return a chair whose operator asks for ahead, and whose person lets nothing pass yet."""
    chair = Chair(replace(RULES, shares=True, acceleration_mps2=1.0))
    chair.run(1.2)
    chair.asked = AHEAD
    chair.run(0.2)
    assert (chair.mode, chair.twist) == ("free", STANDSTILL)
    return chair


def test_a_shared_robot_looks_where_it_is_told() -> None:
    """Sharing scales motion, but not axes."""
    assert driven_shared().axis(0.5) == (SetAxis("pan", 0.5, 1),)


@pytest.mark.parametrize("rules", [RULES, replace(RULES, soft_braking=True)])
def test_whoever_takes_over_lets_go_of_what_the_operator_moves(rules: HandRules) -> None:
    """The person's touch releases the operator's moving controls, while lights still work."""
    chair = driven(rules)
    lift = SetControl("lift", True, 1, moves=True)
    assert chair.control("lift", True) == (lift,)
    chair.stick = (0.5, 0.0)
    calls = chair.run(0.05)
    assert replace(lift, value=False) in calls
    assert chair.mode == "hand"
    assert chair.control("lift", True) == ()
    assert chair.control("lamp", True) == (SetControl("lamp", True, 1, moves=False),)
    chair.stick = (0.0, 0.0)
    assert lift not in chair.run(0.5)
    assert chair.mode == "pause"
    assert chair.control("lamp", False) == (SetControl("lamp", False, 1, moves=False),)
