"""The promises that every driver keeps, whatever robot is behind it, as a suite to inherit."""

from __future__ import annotations

import math
import statistics
import threading
import time
from typing import TYPE_CHECKING, Final

import pytest

from wax.clock import SystemClock
from wax.driver.interface import STANDSTILL, Limits, Twist
from wax.robot.process.pipe_messages import sendable
from wax.testing.bounded import HANGS_S, held, took_s
from wax.testing.driver_under_test import (
    BEAT_S,
    LOOK_S,
    READY_S,
    SILENCE_S,
    STANDS_S,
    STOP_S,
    DriverUnderTest,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.driver.interface import Driver

CLOSE_S: Final = 1.0
OPEN_S: Final = 0.5
CALL_S: Final = 0.005
ROUNDING: Final = 0.01


class DriverSafety(DriverUnderTest):
    """Inherit it in a class named ``Test…``, which must define what `DriverUnderTest` asks for."""

    def test_it_moves_when_told_and_stops_when_told(self, driver: Driver) -> None:
        """A set-point moves the robot either way and a stop ends that; opening it moves nothing."""
        self._open(driver)
        told = self._watch(STANDS_S)
        assert all(twist.is_zero for twist in told), f"opened, it was told to move: {told}"
        for way in self._each_way(driver):
            for asked in (way, way.scaled(-1.0)):
                moving = self._drive(driver, 1, asked)
                assert _goes_along(moving, asked), f"asked for {asked} the wrong way: {moving}"
                driver.stop(1)
                assert self._stands(SILENCE_S), "after a stop the robot was not told to stand"

    def test_it_says_what_it_is_before_it_is_opened(self, driver: Driver) -> None:
        """Kind and limits are known before `open`, are valid and never change."""
        kind, limits = driver.kind, driver.limits
        assert isinstance(kind, str), f"kind is {kind!r}, not a text"
        assert kind, "kind is empty"
        assert isinstance(limits, Limits), f"limits is {limits!r}, not Limits"
        for most in (limits.linear_mps, limits.angular_rps, limits.lateral_mps):
            assert 0.0 <= most < math.inf, f"{limits} must be finite, from 0 on"
        assert all(isinstance(axis, str) for axis in limits.axes), f"axes: {limits.axes!r}"
        self._open(driver)
        assert (driver.kind, driver.limits) == (kind, limits), "open() has changed them"
        driver.close()
        assert (driver.kind, driver.limits) == (kind, limits), "close() has changed them"

    def test_building_it_touches_nothing(self, driver: Driver) -> None:
        """The constructor starts and opens nothing, even while another instance drives the robot.

        The server constructs the class to read its limits while another process drives the robot.
        """
        before = held()
        another = self.make_driver(SystemClock())
        assert held() <= before, f"the constructor has left {held() - before}; do that in open()"
        assert not sendable(another.state()).connected, "it is connected before open()"
        self._open(driver)
        self._drive(driver, turn=1)
        a_third = self.make_driver(SystemClock())
        assert sendable(driver.state()).connected, "to build another has disconnected this one"
        self._drive(driver, turn=1)
        took_s(another.close, HANGS_S)
        took_s(a_third.close, HANGS_S)

    def test_nothing_raises_at_any_time(self, driver: Driver) -> None:
        """Before open, after open and after close every method may be called, twice as well."""

        def everything() -> None:
            for _ in range(2):
                driver.apply(self._ahead(driver), 1)
                for name in (*driver.limits.axes, "no such axis"):
                    for position in (0.5, -7.0, math.nan, math.inf):
                        driver.set_axis(name, position, 1)
                driver.stop(1)
                driver.stop(0)
                sendable(driver.state())

        everything()
        assert not driver.state().connected, "it is connected before open()"
        driver.close()
        self._open(driver)
        driver.open()
        everything()
        driver.close()
        driver.close()
        everything()
        assert not driver.state().connected, "it is connected after close()"

    def test_stop_is_never_refused(self, driver: Driver) -> None:
        """A stop reaches the robot at once, even one of a long past turn."""
        self._open(driver)
        self._stops_at_once(driver, lambda: driver.stop(1), "a stop of an old turn")
        self._stops_at_once(driver, lambda: driver.stop(9), "a stop")
        self._stops_at_once(driver, lambda: driver.apply(STANDSTILL, 9), "a set-point of zero")

    def test_a_stop_is_told_again(self, driver: Driver) -> None:
        """A stop is sent more than once: losing one does not leave the robot moving."""
        if not self.may_lose:
            pytest.skip("this link loses nothing (may_lose)")
        self._open(driver)
        self._drive(driver, turn=1)
        driver.stop(1)
        told = self._watch(SILENCE_S)
        stops = sum(twist.is_zero for twist in told)
        assert stops >= 2, f"a stop was told {stops} times in {SILENCE_S} s: {told}"

    def test_a_lower_turn_is_ignored(self, driver: Driver) -> None:
        """After a set-point or stop of a turn, lower turns can neither start nor sustain motion.

        The previous operator's set-points have no effect, however late they arrive.
        """
        self._open(driver)
        turn = 7
        for way in self._each_way(driver):
            driver.apply(STANDSTILL, turn)
            assert not self._moves(driver, turn - 1, way), "a set-point of an old turn moved it"
            turn += 2
            driver.stop(turn)
            assert not self._moves(driver, turn - 1, way), "a set-point of before the stop moved it"
            self._drive(driver, turn, way)
            self._feed(driver, way, turn - 1, SILENCE_S)
            assert self._stands(STOP_S), "set-points of an old turn kept the robot moving"

    def test_silence_stops_it(self, driver: Driver) -> None:
        """When set-points cease, the driver itself stops the robot within half a second."""
        self._open(driver)
        for way in self._each_way(driver):
            self._drive(driver, 1, way)
            assert self._stands(SILENCE_S), (
                f"{SILENCE_S} s after the last set-point the robot was not told to stand: {way}"
            )

    def test_what_is_no_number_stops_it(self, driver: Driver) -> None:
        """NaN and infinity mean standstill, whether the robot stands or moves."""
        self._open(driver)
        for bad in (math.nan, math.inf, -math.inf):
            for twist in (Twist(bad), Twist(0.0, bad), Twist(0.0, 0.0, bad), Twist(bad, bad, bad)):
                driver.apply(STANDSTILL, 1)
                told = self._feed(driver, twist, 1, 3 * BEAT_S)
                assert all(one.is_zero for one in told), f"{twist} moved the robot: {told}"
        for way in self._each_way(driver):
            self._drive(driver, 1, way)
            bad_way = Twist(lateral_mps=math.nan) if way.lateral_mps else Twist(math.nan)
            self._feed(driver, bad_way, 1, SILENCE_S)
            assert self._stands(STOP_S), "a set-point that is no number kept the robot moving"

    def test_it_keeps_its_limits(self, driver: Driver) -> None:
        """Set-points beyond the limits are clipped to them, a diagonal as a whole.

        A robot that cannot move sideways does nothing of what it is asked to the side.
        """
        self._open(driver)
        limits = driver.limits
        if limits.lateral_mps == 0.0:
            told = self._feed(driver, Twist(lateral_mps=1e3), 1, 5 * BEAT_S)
            assert all(one.is_zero for one in told), f"asked sideways, it was told to move: {told}"
        most = 1 + ROUNDING
        for asked in (
            *(Twist(1e3), Twist(-1e3), Twist(0.0, 1e3), Twist(-1e9, -1e9)),
            *(Twist(0.0, 0.0, 1e3), Twist(1e3, 0.0, -1e3), Twist(-1e9, -1e9, 1e9)),
        ):
            driver.apply(STANDSTILL, 1)
            for twist in self._feed(driver, asked, 1, 5 * BEAT_S):
                assert abs(twist.linear_mps) <= limits.linear_mps * most, (asked, twist)
                assert abs(twist.angular_rps) <= limits.angular_rps * most, (asked, twist)
                assert abs(twist.lateral_mps) <= limits.lateral_mps * most, (asked, twist)
                if limits.linear_mps and limits.lateral_mps:
                    ahead = twist.linear_mps / limits.linear_mps
                    left = twist.lateral_mps / limits.lateral_mps
                    assert math.hypot(ahead, left) <= most, f"a faster diagonal: {asked}, {twist}"

    def test_every_call_returns_at_once(self, driver: Driver) -> None:
        """No method that the control loop calls takes longer than a few milliseconds."""
        assert took_s(driver.open, HANGS_S) < OPEN_S, "open() waits; let a thread do that"
        self._open(driver)
        calls: dict[str, Callable[[], object]] = {
            "apply": lambda: driver.apply(self._ahead(driver), 1),
            "set_axis": lambda: driver.set_axis(next(iter(driver.limits.axes), "pan"), 0.1, 1),
            "stop": lambda: driver.stop(1),
            "state": driver.state,
        }
        for name, call in calls.items():
            times_s: list[float] = []

            def often(call: Callable[[], object] = call, into: list[float] = times_s) -> None:
                for _ in range(50):
                    start_s = time.monotonic()
                    call()
                    into.append(time.monotonic() - start_s)

            took_s(often, HANGS_S)
            median_s = statistics.median(times_s)
            assert median_s < CALL_S, f"{name} takes {median_s * 1000:.1f} ms"

    def test_closing_is_bounded_and_stops_first(self, driver: Driver) -> None:
        """A moving robot is stopped and released within a second."""
        self._open(driver)
        self._drive(driver, turn=1)
        took = took_s(driver.close, HANGS_S)
        assert took < CLOSE_S, f"close() took {took:.2f} s"
        assert not driver.state().connected, "it is connected after close()"
        assert self._stands(STOP_S), "close() did not tell the robot to stand"

    def test_after_closing_nothing_moves(self, driver: Driver) -> None:
        """A stop and a close after the close are harmless, and no set-point opens it again."""
        self._open(driver)
        self._drive(driver, turn=1)
        driver.close()
        driver.stop(1)
        assert self._stands(STOP_S), "after close() it does not stand"
        assert not self._moves(driver, turn=1), "after close() a set-point moved it"
        assert not driver.state().connected, "after close() a set-point has opened it again"
        driver.close()

    def test_a_new_connection_begins_at_standstill(self, driver: Driver) -> None:
        """A set-point from before a reconnection moves nothing after it, and the epoch rises."""
        self._open(driver)
        epoch = driver.state().epoch
        self._drive(driver, turn=1)
        driver.close()
        self._feed(driver, self._ahead(driver), 1, 3 * BEAT_S)
        self._reconnects(driver, driver.open, epoch)

    def test_a_mended_link_begins_at_standstill(self, driver: Driver) -> None:
        """While the link is cut every call returns; earlier set-points move nothing afterwards."""
        self._needs_a_link_to_cut()
        self._open(driver)
        epoch = driver.state().epoch
        self._drive(driver, turn=1)
        self.cut()
        end_s = time.monotonic() + READY_S
        while driver.state().connected:
            assert time.monotonic() < end_s, "the driver does not notice that its link is cut"
            self._feed(driver, self._ahead(driver), 1, BEAT_S)
        self._feed(driver, self._ahead(driver), 1, 10 * BEAT_S)
        self._has_a_problem(driver)
        self._reconnects(driver, self.mend, epoch)
        self._drive(driver, turn=1)

    def test_a_robot_that_is_not_there_holds_nobody_up(self, driver: Driver) -> None:
        """Opening and closing an unreachable robot is quick; meanwhile it reports the problem."""
        self._needs_a_link_to_cut()
        self.cut()
        assert took_s(driver.open, HANGS_S) < OPEN_S, "open() waits for a robot out of reach"
        self._has_a_problem(driver)
        self._feed(driver, self._ahead(driver), 1, 3 * BEAT_S)
        driver.stop(1)
        assert took_s(driver.close, HANGS_S) < CLOSE_S, "close() waits for a robot out of reach"

    def test_anybody_may_stop_it(self, driver: Driver) -> None:
        """A stop from another thread ends the motion that an older turn still asks for."""
        self._open(driver)
        self._drive(driver, turn=1)
        done = threading.Event()

        def drive_on() -> None:
            while not done.wait(BEAT_S / 4):
                driver.apply(self._ahead(driver), 1)

        thread = threading.Thread(target=drive_on, name="drives on", daemon=True)
        thread.start()
        try:
            self._watch(3 * BEAT_S)
            driver.stop(2)
            assert self._stands(SILENCE_S), "it moved on after a stop from another thread"
        finally:
            done.set()
            thread.join(HANGS_S)

    def test_the_state_can_be_asked_by_anybody(self, driver: Driver) -> None:
        """The state is complete and never raises, from any thread, while the robot is driven.

        Complete means that the `RobotState` survives the pipe from the driver's process.
        """
        done = threading.Event()
        raised: list[BaseException] = []

        def ask() -> None:
            epoch = 0
            try:
                while not done.wait(LOOK_S):
                    state = sendable(driver.state())
                    assert state.epoch >= epoch, f"epoch has fallen from {epoch}: {state}"
                    assert state.said is None or str(state.said), f"an empty problem: {state}"
                    epoch = state.epoch
            except BaseException as error:
                raised.append(error)

        thread = threading.Thread(target=ask, name="asks for the state", daemon=True)
        thread.start()
        try:
            for _ in range(2):
                self._open(driver)
                self._drive(driver, turn=1)
                driver.close()
        finally:
            done.set()
            thread.join(HANGS_S)
        if raised:
            raise AssertionError(f"state() failed: {raised[0]!r}") from raised[0]


def _goes_along(told: Twist, asked: Twist) -> bool:
    """Whether a motion is in the direction that was asked for."""
    return (
        told.linear_mps * asked.linear_mps
        + told.angular_rps * asked.angular_rps
        + told.lateral_mps * asked.lateral_mps
    ) > 0
