"""What reaches a robot on ROS 2, with two implementations of DDS."""

from __future__ import annotations

import itertools
import math
import os
import signal
import statistics
import time
from typing import TYPE_CHECKING

import pytest
from tests.robot.ros2.base import Base, own_domain
from tests.robot.ros2.robots import driven, feed, key_to_wire_s, opened, ros2_settings, told, until

from wax.clock import SystemClock
from wax.driver.interface import STANDSTILL, Twist
from wax.robot.find_driver import make_driver, make_robot

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tests.robot.ros2.base import Told

    from wax.driver.interface import Driver

pytest.importorskip("cyclonedds", reason='type: pip install "wax-teleop[ros2]"')
pytestmark = [pytest.mark.system, pytest.mark.full, pytest.mark.alone, pytest.mark.timeout(120)]

ZEROS_S = 1.5
MIN_ZEROS = 30
"""1.5 s at 20 Hz."""
HALF = math.sqrt(0.5)
CURVE = Twist(0.25, -0.5)
SIDEWAYS = Twist(0.25, -0.5, 0.125)


@pytest.fixture(params=[False, True], ids=["CycloneDDS", "Fast DDS"])
def is_fast(request: pytest.FixtureRequest) -> bool:
    return bool(request.param)


@pytest.fixture
def domain() -> int:
    return own_domain()


@pytest.fixture
def base(domain: int, is_fast: bool) -> Iterator[Base]:
    base = Base(domain, fast=is_fast).start()
    yield base
    base.end()


@pytest.fixture
def driver(domain: int, base: Base) -> Iterator[Driver]:
    driver = opened(make_driver(ros2_settings(domain), SystemClock()))
    yield driver
    driver.close()


def zeros_after(base: Base, at_s: float) -> list[Told]:
    """Wait; only standstill may follow `at_s`. Return those of its first `ZEROS_S`."""
    time.sleep(max(0.0, at_s + ZEROS_S + 0.3 - time.monotonic()))
    after = [told for told in base.told() if told.at_s > at_s]
    moving = [told for told in after if not told.twist.is_zero]
    # A command under way at the stop may still arrive.
    assert all(told.at_s - at_s < 0.05 for told in moving), moving
    # After that a new driver may send, once it has found its robot.
    return [told for told in after if told.twist.is_zero and told.at_s <= at_s + ZEROS_S]


def assert_long_enough(zeros: list[Told], at_s: float) -> None:
    assert len(zeros) >= MIN_ZEROS
    assert zeros[0].at_s - at_s < 0.2
    assert zeros[-1].at_s - at_s >= ZEROS_S - 0.05
    gaps_s = [later.at_s - told.at_s for told, later in itertools.pairwise(zeros)]
    assert statistics.median(gaps_s) <= 0.05
    assert max(gaps_s) < 0.25


def test_set_points_arrive_unchanged(base: Base, driver: Driver) -> None:
    """Each speed arrives in its own member; one that the base lacks, and all others, are zero."""
    driven(base, driver, CURVE)
    base.forget()
    feed(driver, SIDEWAYS, for_s=0.3)
    assert {told.twist for told in base.told()} == {CURVE}
    assert {told.others for told in base.told()} == {0.0}


def test_a_set_point_is_repeated_steadily(base: Base, driver: Driver) -> None:
    """A moving robot gets 50 set-points a second, no matter how often WAX sends one."""
    driven(base, driver, CURVE)
    base.forget()
    feed(driver, CURVE, for_s=1.0, every_s=0.1)
    gaps_s = [later.at_s - told.at_s for told, later in itertools.pairwise(base.told())]
    assert 45 <= len(gaps_s) <= 56
    assert 0.018 < statistics.median(gaps_s) < 0.022


def test_a_stop_is_sent_long_enough(base: Base, driver: Driver) -> None:
    """After a stop, standstill comes at 20 Hz or more, for 1.5 s or more."""
    driven(base, driver, CURVE)
    at_s = time.monotonic()
    driver.stop(1)
    assert_long_enough(zeros_after(base, at_s), at_s)


def test_standstill_is_repeated_slowly(base: Base, driver: Driver) -> None:
    """Long after a stop, standstill is still repeated, for a robot that was out of reach."""
    driven(base, driver, CURVE)
    driver.stop(1)
    time.sleep(ZEROS_S + 0.3)
    base.forget()
    time.sleep(1.2)
    assert 1 <= len(base.told()) <= 4
    assert all(told.twist.is_zero for told in base.told())


def test_closing_is_followed_by_standstill(base: Base, driver: Driver) -> None:
    """Closing takes less than 1 s, yet the robot gets standstill for 1.5 s."""
    driven(base, driver, CURVE)
    at_s = time.monotonic()
    driver.close()
    assert time.monotonic() - at_s < 1.0
    assert_long_enough(zeros_after(base, at_s), at_s)


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGSTOP], ids=["killed", "frozen"])
def test_the_standby_acts_for_a_dead_driver(base: Base, domain: int, how: signal.Signals) -> None:
    """If the driver's process is killed or frozen, standstill follows within 0.2 s, and lasts."""
    driver = opened(make_robot(ros2_settings(domain), SystemClock()))
    try:
        driven(base, driver, CURVE)
        pid = int(driver.state().extra["driver_pid"])
        at_s = time.monotonic()
        os.kill(pid, how)
        assert_long_enough(zeros_after(base, at_s), at_s)
    finally:
        driver.close()


def test_nothing_moves_after_a_driver_came_back(base: Base, domain: int) -> None:
    """After the driver's death a held input moves nothing before a new standstill."""
    driver = opened(make_robot(ros2_settings(domain), SystemClock()))
    try:
        driven(base, driver, CURVE)
        epoch = driver.state().epoch
        os.kill(int(driver.state().extra["driver_pid"]), signal.SIGKILL)
        time.sleep(0.2)
        base.forget()
        end_s = time.monotonic() + 20.0
        while not (driver.state().connected and driver.state().epoch > epoch):
            assert time.monotonic() < end_s, driver.state()
            driver.apply(CURVE, 1)
            time.sleep(0.02)
        feed(driver, CURVE, for_s=0.3)
        assert all(told.twist.is_zero for told in base.told())
        driver.apply(STANDSTILL, 1)
        driven(base, driver, CURVE)
    finally:
        driver.close()


@pytest.mark.parametrize("is_fast", [False, True], ids=["CycloneDDS", "Fast DDS"])
def test_stamps_are_by_this_machines_clock(domain: int, is_fast: bool) -> None:
    """TwistStamped carries this machine's time, even at standstill."""
    base = Base(domain, kind="stamped", fast=is_fast).start()
    driver = make_driver(ros2_settings(domain, stamped=True), SystemClock())
    try:
        driven(base, opened(driver), CURVE)
        driver.stop(1)
        time.sleep(0.3)
        ages_s = [
            (told.stamp_ns - time.time_ns()) / 1e9 - (told.at_s - time.monotonic())
            for told in base.told()
        ]
        assert ages_s
        assert all(-0.2 < age_s <= 0.005 for age_s in ages_s)
        assert {told.others for told in base.told()} == {0.0}
    finally:
        driver.close()
        base.end()


@pytest.mark.parametrize("theirs", ["reliable", "best_effort"])
def test_reliable_suits_every_robot(domain: int, is_fast: bool, theirs: str) -> None:
    """By default, the driver reaches robots that require reliable commands and others."""
    base = Base(domain, reliability=theirs, fast=is_fast).start()
    driver = make_driver(ros2_settings(domain), SystemClock())
    try:
        driven(base, opened(driver), CURVE)
    finally:
        driver.close()
        base.end()


def test_odometry_is_read(base: Base, driver: Driver, is_fast: bool) -> None:
    """Pose and motion come from odometry, whose quaternion becomes a heading."""

    def tell() -> None:
        if is_fast:
            base.say_odometry(1.5, -2.0, HALF, HALF, 0.2, 0.0)
        else:
            base.say(
                "nav_msgs/msg/Odometry",
                "/odom",
                {
                    "pose": {
                        "pose": {
                            "position": {"x": 1.5, "y": -2.0},
                            "orientation": {"z": HALF, "w": HALF},
                        }
                    },
                    "twist": {"twist": {"linear": {"x": 0.2}}},
                },
            )

    state = told(driver, tell, lambda state: state.pose is not None)
    assert state.pose is not None
    assert (state.pose.x_m, state.pose.y_m) == (1.5, -2.0)
    assert state.pose.heading_rad == pytest.approx(math.pi / 2)
    assert state.moving is True
    until(driver, lambda state: state.pose is None and state.moving is None)


def test_a_set_point_is_on_the_wire_at_once(base: Base, domain: int) -> None:
    """The median from the server to the robot is less than 25 ms."""
    driver = opened(make_robot(ros2_settings(domain), SystemClock()))
    try:
        took_s = key_to_wire_s(base, driver, 100)
        assert took_s[0] > 0.0
        assert statistics.median(took_s) < 0.025
    finally:
        driver.close()
