"""What the driver writes to the pins and reads from them, on gpiozero's mock pins."""

from __future__ import annotations

import contextlib
import math
import os
import subprocess
import sys
import threading
import time
from typing import TYPE_CHECKING, Any

import gpiozero
import psutil
import pytest
from tests.real_time import may_run_in_real_time
from tests.robot.gpio.conftest import LEFT, MECANUM, RIGHT, Board, settings
from tests.until import until as comes

from wax.clock import SystemClock
from wax.driver.interface import STANDSTILL, Twist
from wax.robot.find_driver import make_driver
from wax.robot.gpio import driver as driver_module
from wax.robot.gpio import guard as guard_module
from wax.robot.gpio import pin_line
from wax.robot.gpio import pins as pins_module
from wax.robot.gpio.guard import BYE, clear
from wax.robot.line import kept_line

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from wax.driver.interface import Driver, RobotState
    from wax.robot.line.core import LineCore


@pytest.fixture
def make(pins: Board, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., Driver]]:
    # `wax.testing` tests silence; here a busy machine must not count as it.
    monkeypatch.setattr(driver_module, "SETPOINT_TTL_S", 60.0)
    made: list[Driver] = []

    def opened(robot: dict[str, Any] | None = None, **gpio: Any) -> Driver:
        driver = make_driver(settings(robot, **gpio), SystemClock())
        made.append(driver)
        driver.open()
        until(driver, lambda state: state.connected)
        return driver

    yield opened
    for driver in made:
        driver.close()


def until(driver: Driver, so: Callable[[RobotState], bool]) -> RobotState:
    end_s = time.monotonic() + 5.0
    while not so(state := driver.state()):
        assert time.monotonic() < end_s, state
        time.sleep(0.002)
    return state


def settle(driver: Driver) -> None:
    """Wait until the set-point is on the pins: a round that began after it has ended."""
    _round(driver)
    _round(driver)


def _round(driver: Driver) -> None:
    core: LineCore = vars(driver)["_core"]
    before = core._newest
    driver.set_axis("no such axis", 0.0, 1)  # only begins a round
    until(driver, lambda _: core._newest is not before)


def feed(driver: Driver, twist: Twist) -> None:
    driver.apply(STANDSTILL, 1)
    driver.apply(twist, 1)
    settle(driver)


@pytest.mark.parametrize(
    ("twist", "left", "right"),
    [
        (Twist(0.6, 0.0), 1.0, 1.0),
        (Twist(-0.3, 0.0), -0.5, -0.5),
        (Twist(0.0, 1.5), -0.375, 0.375),
        (Twist(0.3, 1.0), 0.25, 0.75),
    ],
)
def test_the_motors_follow_the_twist(
    pins: Board, make: Callable[..., Driver], twist: Twist, left: float, right: float
) -> None:
    """Each motor's duty cycle follows its wheel's speed."""
    feed(make(), twist)
    assert pins.motor(LEFT) == pytest.approx(left)
    assert pins.motor(RIGHT) == pytest.approx(right)


@pytest.mark.parametrize(
    ("twist", "shares"),
    [
        (Twist(0.6, 0.0), (0.6, 0.6, 0.6, 0.6)),
        (Twist(0.0, 0.0, 0.6), (-0.6, 0.6, 0.6, -0.6)),
        (Twist(0.0, 1.0), (-0.3, 0.3, -0.3, 0.3)),
        (Twist(0.3, 0.0, -0.3), (0.6, 0.0, 0.0, 0.6)),
    ],
)
def test_four_motors_follow_the_twist_sideways(
    pins: Board, make: Callable[..., Driver], twist: Twist, shares: tuple[float, ...]
) -> None:
    """Each motor of a mecanum base has its own duty cycle; to the left, two of them turn back."""
    driver = make({"base": "mecanum"}, **MECANUM, full_speed_mps=1.0)
    assert driver.limits.lateral_mps == 0.6
    feed(driver, twist)
    assert [pins.motor(motor) for motor in MECANUM.values()] == pytest.approx(shares)


def test_three_motors_and_their_encoders(pins: Board, make: Callable[..., Driver]) -> None:
    """An omni base has a third motor and encoder; its wheels tell its speed to the right."""
    own = {"back": [9, 10, 11], "back_encoder": [5], "left_encoder": [6], "right_encoder": [7]}
    driver = make({"base": "omni"}, **own, steps_per_m=100.0, full_speed_mps=1.0)
    feed(driver, Twist(0.0, 0.0, -0.5))
    assert [pins.motor(motor) for motor in (LEFT, RIGHT, (9, 10, 11))] == pytest.approx(
        [0.25, -0.25, -0.5]
    )
    for encoder, steps in ((6, 1), (7, 1), (5, 2)):
        pins.roll((encoder,), steps)
    state = until(driver, lambda state: state.extra["back_steps"] == -2.0)
    assert (state.extra["left_steps"], state.extra["right_steps"]) == (1.0, -1.0)
    assert state.pose is not None
    assert state.pose.y_m == pytest.approx(-0.02)
    assert state.extra["lateral_mps"] < 0.0
    driver.stop(1)
    settle(driver)
    assert pins.motor((9, 10, 11)) == 0.0


def test_a_robot_that_drifts_is_trimmed_and_inverted(
    pins: Board, make: Callable[..., Driver]
) -> None:
    """Trim, inversion, measured full speed and dead share are applied."""
    driver = make({"right_trim": 0.5, "invert_left": True}, full_speed_mps=1.2, dead_share=0.2)
    feed(driver, Twist(0.6, 0.0))
    assert pins.motor(LEFT) == pytest.approx(-(0.2 + 0.8 * 0.5))
    assert pins.motor(RIGHT) == pytest.approx(0.2 + 0.8 * 0.25)


def test_bridges_with_two_inputs(pins: Board, make: Callable[..., Driver]) -> None:
    """Both inputs have PWM: the one of the direction is on, the other off."""
    driver = make(board="camjam")
    feed(driver, Twist(0.3, 0.0))
    assert [pins.level(pin) for pin in (9, 10, 7, 8)] == [0.5, 0.0, 0.5, 0.0]
    feed(driver, Twist(-0.3, 0.0))
    assert [pins.level(pin) for pin in (9, 10, 7, 8)] == [0.0, 0.5, 0.0, 0.5]


def test_bridges_with_phase_and_enable(pins: Board, make: Callable[..., Driver]) -> None:
    """The phase is the direction, backward is high; enable is the speed."""
    driver = make(board="drv8835")
    feed(driver, Twist(0.3, 0.0))
    assert [pins.level(pin) for pin in (5, 12, 6, 13)] == [0.0, 0.5, 0.0, 0.5]
    feed(driver, Twist(-0.6, 0.0))
    assert [pins.level(pin) for pin in (5, 12, 6, 13)] == [1.0, 1.0, 1.0, 1.0]


def test_a_motor_is_off_before_it_turns_the_other_way(
    pins: Board, make: Callable[..., Driver]
) -> None:
    """A bridge never sees both directions, and the speed is 0 between them."""
    driver = make()
    feed(driver, Twist(0.6, 0.0))
    pins.pin(LEFT[2]).clear_states()
    driver.apply(Twist(-0.6, 0.0), 1)
    settle(driver)
    assert [state for _, state in pins.pin(LEFT[2]).states] == [1.0, 0.0, 1.0]


def test_a_repeated_set_point_is_not_written_again(
    pins: Board, make: Callable[..., Driver]
) -> None:
    """A repeated set-point changes no pin, which would be audible."""
    driver = make()
    feed(driver, Twist(0.3, 0.0))
    pins.pin(LEFT[2]).clear_states()
    for _ in range(15):
        driver.apply(Twist(0.3, 0.0), 1)
        settle(driver)
    assert len(pins.pin(LEFT[2]).states) == 1


def test_servos_turn_the_axes(pins: Board, make: Callable[..., Driver]) -> None:
    """An axis has pulses of 1 to 2 ms every 20 ms, and none before it is first set."""
    driver = make(servos={"pan": 18, "tilt": 19})
    assert driver.limits.axes == ("pan", "tilt")
    assert pins.level(18) == 0.0
    driver.set_axis("pan", -1.0, 1)
    driver.set_axis("tilt", 0.5, 1)
    settle(driver)
    assert pins.level(18) == pytest.approx(0.05)
    assert pins.level(19) == pytest.approx(0.0875)


def test_encoders_give_speed_and_pose(pins: Board, make: Callable[..., Driver]) -> None:
    """Both wheels' steps give the pose; a wheel that turns either way is motion."""
    driver = make(left_encoder=[5, 6], right_encoder=[20, 21], steps_per_m=100.0)
    assert driver.state().moving is False
    for _ in range(10):
        pins.roll((5, 6), 1)
        pins.roll((20, 21), 1)
    state = until(driver, lambda state: state.extra["right_steps"] == 10.0)
    assert state.moving is True
    assert state.pose is not None
    # A round between the two wheels' steps may see the robot turned by one step.
    turned_rad = 0.01 / settings().wheel_base_m
    assert 0.1 * math.cos(turned_rad) <= state.pose.x_m <= 0.1 + 1e-9
    assert state.pose.heading_rad == pytest.approx(0.0)
    assert state.extra["speed_mps"] > 0.0
    assert "lateral_mps" not in state.extra
    pins.roll((20, 21), -5)
    state = until(driver, lambda state: state.extra["right_steps"] == 5.0)
    assert state.pose is not None
    assert state.pose.heading_rad < 0.0
    until(driver, lambda state: state.moving is False)


def test_an_encoder_with_one_pin_counts_the_way_the_motor_goes(
    pins: Board, make: Callable[..., Driver]
) -> None:
    """It counts down when backward, even if the motor is inverted."""
    driver = make({"invert_left": True}, left_encoder=[5], right_encoder=[20])
    feed(driver, Twist(-0.3, 0.0))
    pins.roll((5,), 3)
    pins.roll((20,), 2)
    state = until(driver, lambda state: state.extra["right_steps"] == -2.0)
    assert state.extra["left_steps"] == -3.0


def test_without_encoders_motion_is_unknown(make: Callable[..., Driver]) -> None:
    """Neither motion nor pose is made up."""
    state = make().state()
    assert (state.moving, state.pose) == (None, None)


def test_a_bumper_stops_it(
    pins: Board, make: Callable[..., Driver], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The motors are off without waiting for a poll; the robot may move away from the bumper."""
    monkeypatch.setattr(pin_line, "LOOK_EVERY_S", 60.0)
    monkeypatch.setattr(kept_line, "LONGEST_PAUSE_S", 60.0)
    driver = make(front_bumpers=[20, 21], back_bumpers=[26])
    feed(driver, Twist(0.6, 0.0))
    pins.press(21)
    until(driver, lambda state: state.bumpers == 0b010)
    assert pins.motor(LEFT) == 0.0
    feed(driver, Twist(0.6, 0.0))
    assert pins.motor(LEFT) == 0.0
    feed(driver, Twist(-0.3, 0.0))
    assert pins.motor(LEFT) == -0.5
    pins.press(26)
    until(driver, lambda state: state.bumpers == 0b110)
    feed(driver, Twist(-0.3, 0.0))
    assert pins.motor(LEFT) == 0.0
    feed(driver, Twist(0.0, 1.5))
    assert pins.motor(LEFT) == pytest.approx(-0.375)
    start_s = time.monotonic()
    driver.close()
    assert time.monotonic() - start_s < 1.0


def test_a_bumper_may_only_be_reported(pins: Board, make: Callable[..., Driver]) -> None:
    """With bumpers_stop = false a pressed bumper does not stop the robot."""
    driver = make(front_bumpers=[20], bumpers_stop=False)
    pins.press(20)
    until(driver, lambda state: state.bumpers == 1)
    feed(driver, Twist(0.6, 0.0))
    assert pins.motor(LEFT) == 1.0


def test_pins_in_use_are_retried(pins: Board) -> None:
    """A pin in use is a problem; once it is free, a held input moves nothing."""
    other = gpiozero.DigitalOutputDevice(LEFT[2])
    driver = make_driver(settings(), SystemClock())
    driver.open()
    try:
        state = until(driver, lambda state: state.problem is not None)
        assert "GPIO12" in str(state.problem)
        assert str(state.problem).endswith("Retrying every 0.05 s.")
        driver.apply(STANDSTILL, 1)
        driver.apply(Twist(0.6, 0.0), 1)
        other.close()
        state = until(driver, lambda state: state.connected)
        assert state.epoch == 1
        for _ in range(10):
            driver.apply(Twist(0.6, 0.0), 1)
            time.sleep(0.01)
        assert pins.motor(LEFT) == 0.0
    finally:
        driver.close()


def test_pins_that_fail_are_released_and_reopened(
    pins: Board, make: Callable[..., Driver], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A library error stops the robot and is a problem; the next epoch begins at standstill."""
    driver = make()
    feed(driver, Twist(0.3, 0.0))
    pin = pins.pin(RIGHT[2])
    real = pin._set_state

    def fails(value: float) -> None:
        if value > 0.6:
            raise OSError(5, "Input/output error")
        real(value)

    is_told = threading.Event()
    open_again = pins_module.Pins

    def once_told(*how: Any) -> pins_module.Pins:
        assert is_told.wait(10.0)
        return open_again(*how)

    monkeypatch.setattr(pin, "_set_state", fails)
    monkeypatch.setattr(pins_module, "Pins", once_told)
    driver.apply(Twist(0.6, 0.0), 1)
    state = until(driver, lambda state: state.problem is not None)
    assert "Input/output error" in str(state.problem)
    assert pins.motor(LEFT) == 0.0
    is_told.set()
    state = until(driver, lambda state: state.connected)
    assert state.epoch == 2
    driver.apply(Twist(0.3, 0.0), 1)
    settle(driver)
    assert pins.motor(LEFT) == 0.0


def test_a_computer_without_pins_is_a_problem(monkeypatch: pytest.MonkeyPatch) -> None:
    """On a computer without pins the driver reports that they cannot be used."""
    monkeypatch.setattr(gpiozero.Device, "pin_factory", None)
    monkeypatch.setenv("GPIOZERO_PIN_FACTORY", "native")
    driver = make_driver(settings(), SystemClock())
    driver.open()
    try:
        state = until(driver, lambda state: state.problem is not None)
        assert str(state.problem).startswith("The pins cannot be used")
    finally:
        driver.close()


# --- the guard ----------------------------------------------------------------------------------


def test_the_guard_clears_the_pins(pins: Board) -> None:
    """It waits for a pin that is not free yet."""
    held = gpiozero.DigitalOutputDevice(13, initial_value=True)
    pins.pin(12).function = "output"
    pins.pin(12).state = 1.0
    timer = threading.Timer(0.1, held.close)
    timer.start()
    assert sorted(clear([12, 13])) == [12, 13]
    timer.join()
    assert [pins.level(12), pins.level(13)] == [0.0, 0.0]


@pytest.mark.system
@pytest.mark.parametrize(("last_words", "acts"), [(b"", True), (BYE, False)])
def test_the_guard_acts_only_when_the_driver_has_died(last_words: bytes, acts: bool) -> None:
    """The end of its pipe without a goodbye means the driver's death."""
    guard = subprocess.Popen(
        [sys.executable, "-m", "wax.robot.gpio.guard", "12", "13"],
        stdin=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=os.environ | {"GPIOZERO_PIN_FACTORY": "mock", "GPIOZERO_MOCK_PIN_CLASS": "mockpwmpin"},
    )
    _, said = guard.communicate(last_words, timeout=30)
    assert guard.returncode == 0
    assert (b"pins off: [12, 13]" in said) == acts


@pytest.mark.system
def test_a_driver_has_its_guard_and_dismisses_it(
    pins: Board, make: Callable[..., Driver], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Opening starts the guard, and closing ends it, within 1 s."""
    monkeypatch.setenv("GPIOZERO_PIN_FACTORY", "mock")
    driver = make(guard=True)
    guards = children()
    assert len(guards) == 1
    if may_run_in_real_time():
        comes(lambda: os.sched_getscheduler(guards[0]) == os.SCHED_RR)
    start_s = time.monotonic()
    driver.close()
    assert time.monotonic() - start_s < 1.0
    assert children() == []


def test_the_guard_knows_the_pins_of_all_motors(
    make: Callable[..., Driver], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It would clear those of four motors, not of two."""
    guarded: list[int] = []

    class Recorded:
        def __init__(self, numbers: list[int]) -> None:
            guarded.extend(numbers)

        def dismiss(self) -> None: ...

    monkeypatch.setattr(guard_module, "Guard", Recorded)
    make({"base": "mecanum"}, **MECANUM, guard=True)
    assert guarded == [pin for motor in MECANUM.values() for pin in motor]


def children() -> list[int]:
    """Return this process's children that are guards."""
    found = []
    for child in psutil.Process().children():
        with contextlib.suppress(psutil.Error):  # it has ended
            found += [child.pid] * ("wax.robot.gpio.guard" in child.cmdline())
    return found
