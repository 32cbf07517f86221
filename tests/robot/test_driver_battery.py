"""What every driver promises, whatever robot is behind it."""

from __future__ import annotations

import math
import threading
import time
from typing import TYPE_CHECKING, Any

import pytest

from wax.clock import SystemClock
from wax.config.settings import RobotSettings
from wax.driver.interface import STANDSTILL, Twist
from wax.robot.find_driver import make_driver, make_robot
from wax.robot.process.driver import START_S

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from tests.robot.conftest import Board

    from wax.driver.interface import Driver, RobotState

AHEAD = Twist(0.5, 0.0)


class SimulatedRig:
    """Sees whether the simulated robot moves by its speed."""

    ttl_s = 0.3

    def __init__(self, board: Board) -> None:
        self.driver = make_driver(RobotSettings(), SystemClock())

    def forget(self) -> None:
        """Nothing is kept."""

    def moves(self, during_s: float) -> bool:
        """Tell whether it moves at any time within the next so many seconds."""
        end_s = time.monotonic() + during_s
        while time.monotonic() < end_s:
            if self.driver.state().extra["speed_mps"] != 0.0:
                return True
            time.sleep(0.005)
        return False


class SerialRig:
    """Sees whether a serial robot would move by what comes down the line."""

    dialect = "frames"
    ttl_s: float | None = 0.2
    make = staticmethod(make_driver)

    def __init__(self, board: Board) -> None:
        serial: dict[str, Any] = {"url": str(board.path), "dialect": self.dialect, "axes": ["pan"]}
        settings = RobotSettings.model_validate(
            {"driver": "serial", "serial": serial | {"reopen_s": 0.05}}
        )
        self.driver = self.make(settings, SystemClock())
        self._board = board

    def forget(self) -> None:
        """Leave aside what has come so far."""
        self._board.listen(0.005)
        self._board.forget()

    def moves(self, during_s: float) -> bool:
        """Tell whether anything since `forget`, or within so many seconds, means motion."""
        end_s = time.monotonic() + during_s
        while time.monotonic() < end_s:
            self._board.listen(0.01)
            if self._board.moves(self.dialect):
                return True
        return False


class SingleByteRig(SerialRig):
    dialect = "bytes"
    ttl_s = None  # it holds for ever what it was told


class ProcessRig(SerialRig):
    """The same robot in a process of its own."""

    make = staticmethod(make_robot)


class SingleByteProcessRig(ProcessRig):
    dialect = "bytes"
    ttl_s = None


Rig = SimulatedRig | SerialRig


@pytest.fixture(
    params=[
        SimulatedRig,
        *(
            pytest.param(rig, marks=pytest.mark.system)
            for rig in (SerialRig, SingleByteRig, ProcessRig, SingleByteProcessRig)
        ),
    ]
)
def rig(request: pytest.FixtureRequest, board: Board) -> Iterator[Rig]:
    rig: Rig = request.param(board)
    yield rig
    rig.driver.close()


def until(driver: Driver, so: Callable[[RobotState], bool], within_s: float = 3.0) -> None:
    end_s = time.monotonic() + within_s
    while not so(driver.state()):
        assert time.monotonic() < end_s, driver.state()
        time.sleep(0.002)


def opened(rig: Rig) -> Driver:
    """Open the driver and want standstill once, as the control loop does."""
    rig.driver.open()
    until(rig.driver, lambda state: state.connected, within_s=START_S)
    rig.driver.apply(STANDSTILL, 0)
    return rig.driver


def still(rig: Rig, after_s: float = 0.25) -> bool:
    """Tell whether it stands after so many seconds, and goes on standing."""
    time.sleep(after_s)
    rig.forget()
    return not rig.moves(0.15)


def driven(rig: Rig, twist: Twist, turn: int) -> bool:
    """Want standstill, then this for a while, as the control loop does; tell whether it moves."""
    rig.forget()
    rig.driver.apply(STANDSTILL, turn)
    for _ in range(30):
        rig.driver.apply(twist, turn)
        if rig.moves(0.02):
            return True
    return False


def test_it_moves_when_told_and_stops_when_told(rig: Rig) -> None:
    """A set-point moves the robot, a stop ends that."""
    driver = opened(rig)
    assert still(rig)
    assert driven(rig, AHEAD, 1)
    driver.stop(1)
    assert still(rig)


def test_it_says_what_it_is_before_it_is_opened(rig: Rig) -> None:
    """Kind and limits are known beforehand and never change; the limits are the configured ones."""
    kind, limits = rig.driver.kind, rig.driver.limits
    assert kind in ("simulated", "serial")
    assert (limits.linear_mps, limits.angular_rps) == (0.6, 1.5)
    assert limits.ttl_s == rig.ttl_s
    driver = opened(rig)
    assert (driver.kind, driver.limits) == (kind, limits)
    driver.close()
    assert (driver.kind, driver.limits) == (kind, limits)


def test_nothing_raises_at_any_time(rig: Rig) -> None:
    """Before open, after open and after close every method may be called, twice as well."""
    driver = rig.driver

    def everything() -> None:
        for _ in range(2):
            driver.apply(AHEAD, 1)
            driver.set_axis("pan", 0.5, 1)
            driver.set_axis("no such axis", 0.5, 1)
            driver.stop(1)
            driver.state()

    everything()
    assert not driver.state().connected
    driver.close()
    opened(rig)
    driver.open()
    everything()
    driver.close()
    driver.close()
    everything()
    assert not driver.state().connected


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_what_is_no_number_moves_nothing(rig: Rig, bad: float) -> None:
    """NaN and infinity are standstill, for motion and axes."""
    opened(rig)
    rig.driver.set_axis("pan", bad, 1)
    assert not any(
        driven_once(rig, twist) for twist in (Twist(bad, 0.0), Twist(0.0, bad), Twist(bad, bad))
    )


def driven_once(rig: Rig, twist: Twist) -> bool:
    rig.forget()
    rig.driver.apply(twist, 1)
    return rig.moves(0.06)


def test_a_lower_turn_is_ignored(rig: Rig) -> None:
    """Once a turn was seen, in motion or in a stop, a lower one moves nothing."""
    driver = opened(rig)
    driver.apply(STANDSTILL, 7)
    assert not driven(rig, AHEAD, 6)
    driver.stop(9)
    assert not driven(rig, AHEAD, 8)
    assert driven(rig, AHEAD, 9)


def test_stop_is_never_refused(rig: Rig) -> None:
    """A stop of a turn long past still stops."""
    driver = opened(rig)
    assert driven(rig, AHEAD, 9)
    driver.stop(1)
    assert still(rig)


def test_it_has_a_watchdog(rig: Rig) -> None:
    """When set-points cease it stands within half a second, without being told."""
    opened(rig)
    assert driven(rig, AHEAD, 1)
    assert still(rig, after_s=0.5)


def test_a_new_connection_begins_at_standstill(rig: Rig) -> None:
    """What was wanted before moves nothing after, and the epoch tells the two apart."""
    driver = opened(rig)
    epoch = driver.state().epoch
    assert driven(rig, AHEAD, 1)
    driver.close()
    driver.apply(AHEAD, 1)
    driver.open()
    until(driver, lambda state: state.connected)
    assert driver.state().epoch > epoch
    assert still(rig)


def test_every_call_returns_at_once(rig: Rig) -> None:
    """No method that the control loop calls takes longer than a few milliseconds."""
    driver = opened(rig)
    took_s = []
    for number in range(100):
        start_s = time.monotonic()
        driver.apply(Twist(number / 1000, 0.0), 1)
        driver.set_axis("pan", number / 100, 1)
        driver.stop(1)
        driver.state()
        took_s.append(time.monotonic() - start_s)
    assert sorted(took_s)[50] < 0.005


def test_closing_is_bounded(rig: Rig) -> None:
    """A moving robot is stopped and released within a second."""
    driver = opened(rig)
    assert driven(rig, AHEAD, 1)
    start_s = time.monotonic()
    driver.close()
    assert time.monotonic() - start_s < 1.0
    assert not driver.state().connected


def test_the_state_can_be_asked_by_anybody(rig: Rig) -> None:
    """State is whole and never raises, from any thread, while the robot is driven and reopened."""
    driver = rig.driver
    done = threading.Event()
    failures: list[Exception] = []

    def ask() -> None:
        try:
            while not done.wait(0.001):
                state = driver.state()
                assert state.epoch >= 0
                assert state.said is None or str(state.said).endswith(".")
        except Exception as error:
            failures.append(error)

    thread = threading.Thread(target=ask)
    thread.start()
    try:
        for _ in range(3):
            opened(rig)
            driven(rig, AHEAD, 1)
            driver.close()
    finally:
        done.set()
        thread.join()
    assert failures == []
