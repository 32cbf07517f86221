"""The server's clock includes the machine's sleep, so that old commands and pictures stay old."""

from __future__ import annotations

import time
from contextlib import contextmanager
from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.control.rig import AHEAD, A, Bench

import wax.clock
from wax.clock import SystemClock
from wax.control.reasons import Hold
from wax.driver.interface import STANDSTILL, Limits
from wax.robot.process.driver_watchdog import SILENT, Apply, DriverWatchdog, StopDriver
from wax.robot.process.pipe_messages import Move

if TYPE_CHECKING:
    from collections.abc import Iterator

BEAT_S = 0.02
SILENCE_S = 0.12
LATE_S = 0.25
"""The control loop stops the robot when a beat is more than 200 ms late."""

sleeps_s = st.floats(LATE_S, 1e7)


class Machine:
    """A machine's clocks in place of the module `time`; one of them stops during sleep."""

    CLOCK_BOOTTIME = CLOCK_MONOTONIC_RAW = 7

    def __init__(self) -> None:
        self.awake_s = 1000.0
        self.asleep_s = 0.0

    def sleep(self, duration_s: float) -> None:
        self.asleep_s += duration_s

    def monotonic(self) -> float:
        return self.awake_s

    def clock_gettime(self, clock: int) -> float:
        assert clock == self.CLOCK_BOOTTIME
        return self.awake_s + self.asleep_s


class MachinesClock(SystemClock):
    """The server's clock on that machine; when a bench sets its time, the machine stays awake."""

    def __init__(self, machine: Machine) -> None:
        super().__init__("linux")
        self._machine = machine

    @property
    def time_s(self) -> float:
        return self.now_s()

    @time_s.setter
    def time_s(self, to_s: float) -> None:
        self._machine.awake_s += to_s - self.now_s()


@contextmanager
def running_on(machine: Machine) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(wax.clock, "time", machine)
        yield


@pytest.mark.parametrize("platform", ["linux", "darwin"])
def test_sleep_counts(platform: str) -> None:
    """An hour of sleep is an hour on the server's clock."""
    machine = Machine()
    with running_on(machine):
        clock = SystemClock(platform)
        before_s = clock.now_s()
        machine.awake_s += 1.0
        machine.sleep(3600.0)
        assert clock.now_s() - before_s == 3601.0


@pytest.mark.parametrize("platform", ["win32", "freebsd14"])
def test_elsewhere_the_monotonic_clock_counts(platform: str) -> None:
    """If no clock is known to include sleep, `time.monotonic` is the server's clock."""
    machine = Machine()
    with running_on(machine):
        assert SystemClock(platform).now_s() == machine.awake_s


def test_a_system_without_that_clock_falls_back(monkeypatch: pytest.MonkeyPatch) -> None:
    """A Linux whose Python does not know the clock still has one."""
    monkeypatch.delattr(Machine, "CLOCK_BOOTTIME")
    machine = Machine()
    with running_on(machine):
        assert SystemClock("linux").now_s() == machine.awake_s


def test_it_is_never_behind_the_monotonic_clock() -> None:
    """On this machine, too, the clock has counted at least what `time.monotonic` has."""
    before_s = time.monotonic()
    assert SystemClock().now_s() >= before_s


@given(sleeps_s)
def test_after_a_sleep_a_held_key_moves_nothing(slept_s: float) -> None:
    """After a resume the robot gets a stop first, and a held key moves it only after neutral."""
    machine = Machine()
    with running_on(machine):
        bench = Bench(clock=MachinesClock(machine))
        bench.enter(A)
        bench.step()
        bench.drive()
        machine.sleep(slept_s)
        assert bench.step(BEAT_S)[0] == ("stop", 1)
        assert bench.statuses[-1] == (A, False, Hold.LATE.value)
        assert not bench.moves()
        bench.drive()


@given(sleeps_s)
def test_a_command_that_wakes_the_server_moves_nothing(slept_s: float) -> None:
    """A fresh command before the first beat after a resume moves nothing."""
    machine = Machine()
    with running_on(machine):
        bench = Bench(clock=MachinesClock(machine))
        bench.enter(A)
        bench.step()
        bench.drive()
        machine.sleep(slept_s)
        bench.driver.take()
        bench.offer(0.5)
        told = [*bench.driver.take(), *bench.step()]
        assert told[0] == ("stop", 1)
        assert {call[1] for call in told if call[0] == "apply"} == {STANDSTILL}


@given(sleeps_s)
def test_after_a_sleep_the_drivers_process_stops_the_robot(slept_s: float) -> None:
    """The driver's process takes a sleep for silence: it stops, and waits for standstill."""
    machine = Machine()
    with running_on(machine):
        clock = SystemClock("linux")
        warden = DriverWatchdog(Limits(0.5, 1.0), SILENCE_S)

        def say(sequence: int, linear_mps: float) -> object:
            now_s = clock.now_s()
            move = Move(
                sequence=sequence, sent_s=now_s, turn=1, linear_mps=linear_mps, angular_rps=0.0
            )
            return warden.handle(move, now_s)[-1]

        say(1, 0.0)
        machine.awake_s += BEAT_S
        assert say(2, AHEAD.linear_mps) == Apply(AHEAD, 1)
        machine.sleep(slept_s)
        machine.awake_s += BEAT_S
        assert warden.repeat(clock.now_s()) == (StopDriver(1), Apply(STANDSTILL, 1))
        assert warden.problem == SILENT
        machine.awake_s += BEAT_S
        assert say(3, AHEAD.linear_mps) == Apply(STANDSTILL, 1)
        machine.awake_s += BEAT_S
        say(4, 0.0)
        assert say(5, AHEAD.linear_mps) == Apply(AHEAD, 1)
