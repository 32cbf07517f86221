"""The standby as the driver sees it, simulated by short programs."""

from __future__ import annotations

import math
import os
import select
import signal
import subprocess
import sys
import time
from typing import TYPE_CHECKING, Any, Final

import pytest
from tests.robot.ros2.robots import ros2_settings
from tests.turned_clock import TurnedClock

from wax.clock import SystemClock
from wax.robot.ros2 import standby_process
from wax.robot.ros2.settings import Ros2Settings
from wax.robot.ros2.standby_process import STARTS, StandbyProcess
from wax.robot.ros2.standby_rules import SILENCE_S

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from wax.clock import Clock
    from wax.sentence import Sentence

pytestmark = pytest.mark.system

_LIVES: Final = """
import os, sys, time
sys.stdin.readline()
while True:
    os.write(1, b"me 1\\n")  # in one piece: an unbuffered print writes the newline separately
    time.sleep(0.05)
"""
_STARTS: Final = """
import sys, time
sys.stdin.readline()
time.sleep(60)
"""
_LOSES: Final = """
import os, sys, time
sys.stdin.readline()
os.write(1, b"me 1\\n- 0\\n")
time.sleep(60)
"""
_TRACES: Final = r"""
import sys, time
sys.stdin.readline()
print("trace", flush=True)
time.sleep(0.2)
sys.stdout.buffer.write(b"me 1\n\n1 2 3\nme many\n\xff\xfe 7\n")
sys.stdout.flush()
time.sleep(60)
"""


@pytest.fixture
def play(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., StandbyProcess]]:
    """Return a function that makes a standby from a program's text."""
    made: list[StandbyProcess] = []

    def play(program: str, clock: Clock | None = None) -> StandbyProcess:
        monkeypatch.setattr(standby_process, "_COMMAND", [sys.executable, "-c", program])
        own = ros2_settings(0, reopen_s=3.0).own(Ros2Settings)
        made.append(StandbyProcess(own, clock or SystemClock()))
        return made[-1]

    yield play
    for standby in made:
        process = standby._process
        standby.leave()
        if process is not None:
            process.kill()


def until(standby: StandbyProcess, said: Sentence | None, within_s: float = 10.0) -> None:
    end_s = time.monotonic() + within_s
    while standby.poll() != said:
        assert time.monotonic() < end_s
        time.sleep(0.02)


def ready(standby: StandbyProcess) -> subprocess.Popen[bytes]:
    until(standby, None)
    assert standby._process is not None
    return standby._process


def test_what_a_library_prints_is_ignored(play: Callable[..., StandbyProcess]) -> None:
    """Lines that are not the standby's own neither raise nor change its report."""
    standby = play(_TRACES)
    until(standby, None)
    assert standby.guid == "me"


def test_one_that_ends_at_once_is_no_error(
    play: Callable[..., StandbyProcess], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A standby that has ended before it got its settings is only not ready."""

    def ended(*args: Any, **how: Any) -> subprocess.Popen[bytes]:
        process = real(*args, **how)
        process.wait(10)
        return process

    real = subprocess.Popen
    monkeypatch.setattr(subprocess, "Popen", ended)
    standby = play("")
    assert standby.poll() == STARTS
    standby.report(owes=True)
    assert standby.poll() == STARTS


def test_one_that_freezes_is_replaced(
    play: Callable[..., StandbyProcess],
) -> None:
    """A standby that is silent for 1 s is killed; the robot is held until the next one is ready."""
    clock = TurnedClock(100.0)
    standby = play(_LIVES, clock)
    frozen = ready(standby)
    os.kill(frozen.pid, signal.SIGSTOP)
    os.waitpid(frozen.pid, os.WUNTRACED)
    assert standby.poll() is None
    clock.time_s += 0.99
    assert standby.poll() is None
    clock.time_s += 0.02
    assert standby.poll() == STARTS
    assert (standby.guid, standby.guids) == ("", {"me"})
    assert frozen.wait(5) == -signal.SIGKILL
    until(standby, None)
    assert standby._process is not frozen


def test_one_that_has_died_is_reported_before_another_starts(
    play: Callable[..., StandbyProcess],
) -> None:
    """Starting a process takes time, during which the robot must not move."""
    clock = TurnedClock(100.0)
    standby = play(_LIVES, clock)
    process = ready(standby)
    process.kill()
    process.wait(5)
    clock.time_s += 5.0
    assert standby.poll() == STARTS
    assert standby._process is None
    until(standby, None)


def test_its_waiting_lines_are_read_before_its_silence_is_judged(
    play: Callable[..., StandbyProcess],
) -> None:
    """A driver that was frozen itself does not count its standby as dead."""
    clock = TurnedClock(100.0)
    standby = play(_LIVES, clock)
    process = ready(standby)
    assert process.stdout is not None
    assert select.select([process.stdout], [], [], 10.0)[0]
    clock.time_s += 5.0
    assert standby.poll() is None
    assert standby._process is process


@pytest.mark.parametrize("program", [_STARTS, _LOSES], ids=["starting", "connecting"])
def test_one_that_connects_has_longer(play: Callable[..., StandbyProcess], program: str) -> None:
    """Before it reaches the robot it has 20 s and the pause between two attempts."""
    clock = TurnedClock(100.0)
    standby = play(program, clock)
    assert standby.poll() == STARTS
    process = standby._process
    assert process is not None
    if program == _LOSES:
        end_s = time.monotonic() + 10.0
        while not standby.guid:
            assert time.monotonic() < end_s
            standby.poll()
    clock.time_s += 22.9
    assert standby.poll() == STARTS
    assert standby._process is process
    clock.time_s += 0.2
    assert standby.poll() == STARTS
    assert process.wait(5) == -signal.SIGKILL
    standby.poll()
    assert standby._process not in (None, process)


def test_it_is_known_when_it_sends(play: Callable[..., StandbyProcess]) -> None:
    """It sends 0.12 s after the driver's last report, unless that was that the robot stands."""
    standby = play(_LIVES, TurnedClock(100.0))
    standby.poll()
    assert standby.speaks_at_s == math.inf
    standby.report(owes=True)
    assert standby.speaks_at_s == 100.0 + SILENCE_S
    standby.report(owes=False)
    assert standby.speaks_at_s == math.inf
    standby.report(owes=True)
    standby.leave()
    assert standby.speaks_at_s == math.inf


def test_one_that_reads_nothing_blocks_nobody(play: Callable[..., StandbyProcess]) -> None:
    """Reports that do not fit into the pipe are dropped."""
    standby = play(_LIVES)
    until(standby, None)
    for _ in range(70_000):
        standby.report(owes=True)
    assert standby.poll() is None
