"""A set-point on its way to the robot, hop by hop."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples
from tests.turned_clock import TurnedClock

from wax.config.local import LocalSettings
from wax.config.robot import RobotSettings
from wax.control.local_hand import HandRules
from wax.driver.checks import within
from wax.driver.hand import HandReading
from wax.driver.interface import STANDSTILL, Limits, Twist
from wax.robot.line.setpoints import SetPoints
from wax.robot.process.driver import ProcessDriver
from wax.robot.process.driver_watchdog import Apply, DriverWatchdog
from wax.robot.process.hand_watchdog import HandWatchdog
from wax.robot.process.pipe_messages import Message, Move, decode_message, encode
from wax.robot.ros2 import rosbridge_protocol
from wax.robot.simulated.chair import SimulatedChair

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.robot.process.driver_watchdog import Call

LIMITS = Limits(0.6, 1.5, lateral_mps=0.4)
NOW_S = 100.0
LOCAL = LocalSettings(source="robot")
speeds = st.floats(-2.0, 2.0)
twists = st.builds(Twist, speeds, speeds, speeds).map(lambda twist: within(twist, LIMITS))


class Spoken(ProcessDriver):
    """The server's end of the pipe, without a process."""

    def _say(self, message: Message) -> None:
        self.line = encode(message)


def by_pipe(twist: Twist) -> Move:
    """Return the message that the driver's process reads."""
    driver = Spoken(RobotSettings(), TurnedClock(), kind="", limits=LIMITS)
    driver.apply(twist, 1)
    message = decode_message(driver.line)
    assert isinstance(message, Move)
    return message


class Overheard(DriverWatchdog):
    """The simulated robot's own end: its process is the server's."""

    def handle(self, message: Message, now_s: float) -> tuple[Call, ...]:
        self.message = message
        return super().handle(message, now_s)


def by_chair(twist: Twist) -> Move:
    """Return the message that the simulated robot's watchdog gets with a person aboard."""
    chair = SimulatedChair(RobotSettings(), LOCAL, TurnedClock())
    chair._watchdog = watchdog = Overheard(LIMITS, 1.0)  # type: ignore[assignment] # of that form
    chair.apply(twist, 1)
    assert isinstance(watchdog.message, Move)
    return watchdog.message


def applied(watchdog: DriverWatchdog | HandWatchdog, twist: Twist) -> Twist:
    """Return what the driver is called with: standstill first, then this."""
    for number, one in enumerate((STANDSTILL, twist)):
        said = by_pipe(one).model_copy(update={"sequence": number, "sent_s": NOW_S + number / 100})
        calls = watchdog.handle(said, NOW_S + number / 100)
    (call,) = [call for call in calls if isinstance(call, Apply)]
    return call.twist


def by_hand_watchdog(twist: Twist) -> Twist:
    """Let it through once nobody's hand has been on the control for a while."""
    rules = HandRules.of(LOCAL, RobotSettings(), 0.02)
    watchdog = HandWatchdog(DriverWatchdog(LIMITS, 1.0), rules)
    for step in range(-100, 1):
        at_s = NOW_S + step / 20
        watchdog.handle_readings([HandReading(at_s)], at_s)
    assert watchdog.aboard.mode == "free"
    return applied(watchdog, twist)


def by_setpoints(twist: Twist) -> Twist:
    setpoints = SetPoints(LIMITS, 1.0)
    setpoints.connected()
    for one in (STANDSTILL, twist):
        setpoints.apply(one, 1, NOW_S)
    return setpoints.order(NOW_S)[0].twist


def by_rosbridge(twist: Twist) -> Twist:
    said = json.loads(rosbridge_protocol.publish("/cmd_vel", twist))["msg"]
    return Twist(said["linear"]["x"], said["angular"]["z"], said["linear"]["y"])


def of(move: Move) -> Twist:
    return Twist(move.linear_mps, move.angular_rps, move.lateral_mps)


HOPS: dict[str, Callable[[Twist], Twist]] = {
    "pipe": lambda twist: of(by_pipe(twist)),
    "chair": lambda twist: of(by_chair(twist)),
    "driver's watchdog": lambda twist: applied(DriverWatchdog(LIMITS, 1.0), twist),
    "hand's watchdog": by_hand_watchdog,
    "set-points": by_setpoints,
    "rosbridge": by_rosbridge,
}


@pytest.mark.parametrize("hop", HOPS)
@given(twist=twists)
@examples(100)
def test_a_set_point_keeps_all_its_parts(hop: str, twist: Twist) -> None:
    """Ahead, turning and sideways leave each hop as they came."""
    told = HOPS[hop](twist)
    parts = (told.linear_mps, told.angular_rps, told.lateral_mps)
    assert parts == pytest.approx((twist.linear_mps, twist.angular_rps, twist.lateral_mps))
