"""Why a robot cannot be driven, and what it reports of itself."""

from __future__ import annotations

import os
import signal
import time
from typing import TYPE_CHECKING, Any

import pytest
from tests.examples import at_length
from tests.robot.ros2.base import Base, own_domain
from tests.robot.ros2.robots import driven, feed, opened, ros2_settings, standing, told, until

from wax.clock import SystemClock
from wax.driver.interface import STANDSTILL, Twist
from wax.robot.find_driver import make_driver
from wax.robot.ros2.standby_process import STARTS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from wax.driver.interface import Driver, RobotState

pytest.importorskip("cyclonedds", reason='type: pip install "wax-teleop[ros2]"')
pytestmark = [pytest.mark.system, pytest.mark.timeout(120)]

AHEAD = Twist(0.3, 0.0)


@pytest.fixture
def domain() -> int:
    return own_domain()


@pytest.fixture
def base(domain: int) -> Iterator[Base]:
    base = Base(domain)
    yield base
    base.end()


@pytest.fixture
def make(domain: int) -> Iterator[Callable[..., Driver]]:
    made: list[Driver] = []

    def make(**own: Any) -> Driver:
        made.append(make_driver(ros2_settings(domain, **own), SystemClock()))
        return made[-1]

    yield make
    for driver in made:
        driver.close()


def says(code: str) -> Callable[[RobotState], bool]:
    return lambda state: state.said is not None and state.said.code == code


def test_nobody_listens(make: Callable[..., Driver]) -> None:
    """Without a subscriber there is no robot, which is a problem."""
    driver = make()
    driver.open()
    until(driver, says("ros2.nobody_listens"))
    assert not driver.state().connected


def test_a_second_publisher_stops_the_robot(
    make: Callable[..., Driver], base: Base, domain: int
) -> None:
    """While somebody else publishes, too, the robot gets standstill, and nothing moves it."""
    driver = opened_on(base, make())
    driven(base, driver, AHEAD)
    other = Base(domain, topic="/elsewhere").start()
    try:
        other.say("geometry_msgs/msg/Twist", "/cmd_vel")
        until(driver, says("ros2.other_publisher"))
        # Before, a driver whose thread is 120 ms late begins a new epoch by itself.
        epoch = driver.state().epoch
        assert not driver.state().connected
        standing(base)
        base.forget()
        forgot_s = time.monotonic()
        feed(driver, AHEAD, for_s=0.5)
        # After standstill's time the topic is the other publisher's.
        while time.monotonic() - max([forgot_s, *(told.at_s for told in base.told())]) < 1.2:
            time.sleep(0.05)
        assert all(told.twist.is_zero for told in base.told())
    finally:
        other.end()
    until(driver, lambda state: state.connected)
    assert driver.state().epoch == epoch + 1
    base.forget()
    feed(driver, AHEAD, for_s=0.3)
    assert all(told.twist.is_zero for told in base.told())


def test_a_base_that_returns_stands(make: Callable[..., Driver], base: Base) -> None:
    """A held input does not move a base that has ended and restarted; a stop reaches it."""
    driver = opened_on(base, make())
    driven(base, driver, AHEAD)
    driver.stop(1)
    standing(base)
    base.forget()
    driven(base, driver, AHEAD)
    base.end()
    until(driver, lambda state: not state.connected)
    base.forget()
    base.start()
    until(driver, lambda state: state.connected)
    feed(driver, AHEAD, for_s=0.3)
    assert base.told()
    assert all(told.twist.is_zero for told in base.told())


@pytest.mark.full
def test_a_frozen_standby_is_no_stranger(make: Callable[..., Driver], base: Base) -> None:
    """The next standby takes its place, although DDS lists the killed one for 10 s more."""
    driver = opened_on(base, make())
    driven(base, driver, AHEAD)
    os.kill(vars(driver)["_session"]._standby._process.pid, signal.SIGSTOP)
    until(driver, lambda state: state.said == STARTS)
    standing(base)
    base.forget()
    feed(driver, AHEAD, for_s=0.2)
    assert {told.twist for told in base.told()} == {STANDSTILL}
    until(driver, lambda state: state.connected, 8.0)


def test_another_server_is_named(make: Callable[..., Driver], base: Base) -> None:
    """Two servers on one topic both report it, and neither drives."""
    first = opened_on(base, make())
    second = make()
    second.open()
    until(first, says("ros2.other_wax"))
    until(second, says("ros2.other_wax"))


@pytest.mark.parametrize(("theirs", "ours"), [("stamped", False), *at_length(("twist", True))])
def test_a_wrong_type_is_named(
    make: Callable[..., Driver], domain: int, theirs: str, ours: bool
) -> None:
    """A robot that takes the other kind of Twist gets nothing; the problem names both types."""
    base = Base(domain, kind=theirs).start()
    try:
        driver = make(stamped=ours)
        driver.open()
        until(driver, says("ros2.wrong_type"))
        types = {"geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"}
        said = driver.state().said
        assert said is not None
        assert types == {said.values["theirs"], said.values["ours"]}
        assert ("Stamped" in str(said.values["ours"])) == ours
        assert base.told() == []
    finally:
        base.end()


def test_commands_that_the_robot_refuses_are_named(make: Callable[..., Driver], base: Base) -> None:
    """Best effort does not reach a robot that requires reliable commands."""
    base.start()
    driver = make(reliability="best_effort")
    driver.open()
    until(driver, says("ros2.wrong_qos"))
    assert not driver.state().connected


def test_an_interface_that_is_not_there_is_named(make: Callable[..., Driver]) -> None:
    """DDS that cannot start is a problem that names the interface."""
    driver = make(interface="10.254.254.1")
    driver.open()
    until(driver, says("ros2.no_dds"))
    assert "10.254.254.1" in str(driver.state().said)


HAZARDS = "irobot_create_msgs/msg/HazardDetectionVector"


def test_the_robots_state_is_read(make: Callable[..., Driver], base: Base) -> None:
    """Voltage and charge, a collision while it lasts, and an ERROR in the robot's own words."""
    topics = {"battery": "/battery_state", "bumper": "/bumper", "diagnostics": "/diagnostics"}
    driver = opened_on(base, make(**topics, bumper_type=HAZARDS))
    message = {"voltage": 11.5, "percentage": 0.75, "cell_voltage": [3.5, 4.0], "location": "rear"}
    state = told(
        driver,
        lambda: base.say("sensor_msgs/msg/BatteryState", "/battery_state", message),
        lambda state: state.battery_v is not None,
    )
    assert (state.battery_v, state.battery_fraction) == (11.5, 0.75)

    def bump(kind: int) -> Callable[[], None]:
        return lambda: base.say(HAZARDS, "/bumper", {"detections": [{"type": kind}]})

    told(driver, bump(1), lambda state: state.bumpers > 0)
    told(driver, bump(3), lambda state: not state.bumpers)

    def tell(level: int) -> Callable[[], None]:
        status = {"level": level, "name": "motors", "message": "too hot", "values": [{"key": "t"}]}
        message = {"status": [status]}
        return lambda: base.say("diagnostic_msgs/msg/DiagnosticArray", "/diagnostics", message)

    state = told(driver, tell(2), lambda state: state.problem is not None)
    assert str(state.said) == "The robot reports a fault: motors: too hot."
    told(driver, tell(1), lambda state: state.problem is None)


@pytest.mark.full
@pytest.mark.parametrize(
    ("type_name", "pressed", "released"),
    [
        ("std_msgs/msg/Bool", {"data": True}, {"data": False}),
        (
            "kobuki_ros_interfaces/msg/BumperEvent",
            {"bumper": 1, "state": 1},
            {"bumper": 1, "state": 0},
        ),
    ],
)
def test_the_bumper_is_read(
    make: Callable[..., Driver], base: Base, type_name: str, pressed: Any, released: Any
) -> None:
    """A collision is reported while it lasts, in each of the older types."""
    driver = opened_on(base, make(bumper="/bumper", bumper_type=type_name))
    told(driver, lambda: base.say(type_name, "/bumper", pressed), lambda state: state.bumpers > 0)
    told(driver, lambda: base.say(type_name, "/bumper", released), lambda state: not state.bumpers)


@pytest.mark.parametrize("is_fast", [False, *at_length(True)], ids=["CycloneDDS", "Fast DDS"])
@pytest.mark.parametrize("name", ["cmd_vel_timeout", *at_length("velocity_timeout")])
def test_the_robots_timeout_is_requested(
    make: Callable[..., Driver], domain: int, is_fast: bool, name: str
) -> None:
    """The timeout of the node that takes the commands is reported, with either DDS."""
    base = Base(domain, fast=is_fast).start()
    try:
        base.promise("/base", name, 0.5)
        driver = opened(make(timeout_s=0.5))
        until(driver, lambda state: state.ttl_s == 0.5)
        assert driver.state().extra["ros2_timeout_s"] == 0.5
        assert driver.limits.ttl_s == 0.5
        assert driver.state().connected
    finally:
        base.end()


@pytest.mark.parametrize("theirs", [0.0, *at_length(1.0)])
def test_a_robot_that_promises_less_is_not_driven(
    make: Callable[..., Driver], base: Base, theirs: float
) -> None:
    """A timeout that is off, or longer than configured, is a problem."""
    base.start()
    base.promise("/controllers/diff", "cmd_vel_timeout", theirs)
    driver = make(timeout_s=0.5)
    driver.open()
    until(driver, says("ros2.other_timeout"))
    assert not driver.state().connected


def opened_on(base: Base, driver: Driver) -> Driver:
    base.start()
    return opened(driver)
