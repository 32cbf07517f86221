"""A driver under test: how the suite makes it, drives it as the server does, and observes it."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar, Final

import pytest

from wax.clock import SystemClock
from wax.driver.interface import STANDSTILL, Twist
from wax.robot.process.pipe_messages import sendable
from wax.testing.bounded import HANGS_S, took_s

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from wax.clock import Clock
    from wax.driver.interface import Driver, RobotState

READY_S: Final = 20.0
"""How long to wait for a driver, as WAX does: libraries may load slowly on a small machine."""
MOVES_S: Final = 5.0
STOP_S: Final = 0.1
"""From a stop to standstill on the link: five ticks, and less than any watchdog's timeout."""
SILENCE_S: Final = 0.5
"""From the last set-point to standstill, by the driver's own watchdog."""
STANDS_S: Final = 0.15
BEAT_S: Final = 0.02
LOOK_S: Final = 0.002
TRIES: Final = 3
"""A busy machine may delay a thread; a driver that does not stop fails every time."""


class DriverUnderTest(ABC):
    """What a driver's test must define, and how the suite uses it.

    The suite drives as the server does: it opens the driver, asks for standstill, then repeats the
    set-point fifty times a second. If `commanded` observes the robot's motion instead of its input,
    `braking_s` is how long it takes to brake from half its speed.
    """

    braking_s: ClassVar[float] = 0.0
    may_lose: ClassVar[bool] = True
    """Whether the link can lose a stop, which must then be sent again."""

    @abstractmethod
    def make_driver(self, clock: Clock) -> Driver:
        """Construct the driver for this test's robot as the server would; do not open it."""

    @abstractmethod
    def commanded(self) -> Sequence[Twist]:
        """Return the set-points that have reached the robot since the last call, oldest first.

        A stop is `STANDSTILL`. If only the robot can be observed, return how it moves now.
        """

    def cut(self) -> None:
        """Break the link to the robot, as a pulled plug does; safe before the driver is opened."""
        raise NotImplementedError

    def mend(self) -> None:
        """Repair the link."""
        raise NotImplementedError

    @pytest.fixture
    def driver(self) -> Iterator[Driver]:
        driver = self.make_driver(SystemClock())
        yield driver
        took_s(driver.close, HANGS_S)

    _last = STANDSTILL
    """The newest set-point that reached the robot; pytest makes a new object for each test."""

    def _open(self, driver: Driver) -> None:
        """Open it and ask for standstill once, as the control loop does."""
        took_s(driver.open, HANGS_S)
        self._until(driver, lambda state: state.connected, "connects", READY_S)
        driver.apply(STANDSTILL, 0)

    def _ahead(self, driver: Driver) -> Twist:
        """Half of the robot's speed ahead, or on the spot if it can only turn."""
        limits = driver.limits
        turning_rps = 0.0 if limits.linear_mps else limits.angular_rps
        return Twist(limits.linear_mps, turning_rps).scaled(0.5)

    def _each_way(self, driver: Driver) -> list[Twist]:
        """Half of the robot's speed ahead, and sideways if it can."""
        sideways = Twist(lateral_mps=driver.limits.lateral_mps / 2.0)
        return [self._ahead(driver), *([] if sideways.is_zero else [sideways])]

    def _watch(self, for_s: float) -> list[Twist]:
        """Return the set-points that reach the robot within this time."""
        told: list[Twist] = []
        end_s = time.monotonic() + for_s
        while True:
            told += self.commanded()
            if told:
                self._last = told[-1]
            if time.monotonic() >= end_s:
                return told
            time.sleep(LOOK_S)

    def _feed(self, driver: Driver, twist: Twist, turn: int, for_s: float) -> list[Twist]:
        """Ask for this fifty times a second; return the set-points that reach the robot."""
        told: list[Twist] = []
        end_s = time.monotonic() + for_s
        while time.monotonic() < end_s:
            driver.apply(twist, turn)
            told += self._watch(BEAT_S)
        return told

    def _drive(self, driver: Driver, turn: int, way: Twist | None = None) -> Twist:
        """Ask for standstill, then motion, until it reaches the robot; return what reached it.

        The motion is ahead unless another `way` is given.
        If the driver has begun a new epoch meanwhile, ask for standstill again, as a person must.
        """
        epoch = -1
        end_s = time.monotonic() + MOVES_S
        while True:
            if epoch != (epoch := driver.state().epoch):
                self._feed(driver, STANDSTILL, turn, 2 * BEAT_S)
            told = self._feed(driver, way or self._ahead(driver), turn, BEAT_S)
            if moving := [twist for twist in told if not twist.is_zero]:
                return moving[-1]
            assert time.monotonic() < end_s, (
                f"a set-point did not move the robot within {MOVES_S:g} s: {driver.state()}"
            )

    def _moves(self, driver: Driver, turn: int, way: Twist | None = None) -> bool:
        """Ask for standstill, then motion, for a while; return whether motion reached the robot."""
        self._watch(0.0)
        driver.apply(STANDSTILL, turn)
        told = self._feed(driver, way or self._ahead(driver), turn, 10 * BEAT_S)
        return not all(twist.is_zero for twist in told)

    def _stands(self, within_s: float) -> bool:
        """Return whether the robot is stopped within this time and stays stopped."""
        end_s = time.monotonic() + within_s + self.braking_s
        self._watch(0.0)
        while not self._last.is_zero:
            if time.monotonic() >= end_s:
                return False
            self._watch(LOOK_S)
        return all(twist.is_zero for twist in self._watch(STANDS_S))

    def _stops_at_once(self, driver: Driver, stop: Callable[[], None], what: str) -> None:
        """Drive, stop in this way, and check that it takes less time than any watchdog."""
        within_ms = (STOP_S + self.braking_s) * 1000
        for way in self._each_way(driver):
            for _ in range(TRIES):
                self._drive(driver, 9, way)
                stop()
                if self._stands(STOP_S):
                    break
                assert self._stands(SILENCE_S), f"{what} did not stop the robot at all"
            else:
                raise AssertionError(f"{what} was not told within {within_ms:.0f} ms: {way}")

    def _reconnects(self, driver: Driver, how: Callable[[], object], epoch: int) -> None:
        """Check that the robot stands once it has reconnected, in a later epoch."""
        self._watch(0.0)
        took_s(how, HANGS_S)
        self._until(driver, lambda state: state.connected, "connects again", READY_S)
        assert driver.state().epoch > epoch, "epoch must rise with each connection"
        assert all(twist.is_zero for twist in self._watch(2 * STANDS_S)), (
            "a set-point of before moved the robot after it was connected again"
        )

    def _until(
        self, driver: Driver, so: Callable[[RobotState], bool], what: str, within_s: float
    ) -> None:
        end_s = time.monotonic() + within_s
        while not so(state := sendable(driver.state())):
            assert time.monotonic() < end_s, f"not within {within_s:g} s it {what}: {state}"
            time.sleep(LOOK_S)

    def _has_a_problem(self, driver: Driver) -> None:
        end_s = time.monotonic() + READY_S
        while (state := sendable(driver.state())).said is None:
            assert time.monotonic() < end_s, f"without its robot it has no problem to say: {state}"
            time.sleep(LOOK_S)
        assert not state.connected, f"it is connected, and has a problem: {state}"

    def _needs_a_link_to_cut(self) -> None:
        if type(self).cut is DriverUnderTest.cut:
            pytest.skip("the suite is not told how to cut this link: write cut() and mend()")
