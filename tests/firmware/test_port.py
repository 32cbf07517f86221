"""The test that any port of the firmware can run finds whatever a board does wrong."""

from __future__ import annotations

import subprocess
from functools import cache
from pathlib import Path

import pytest
from tests.firmware.core import ROOT

pytestmark = pytest.mark.system

BROKEN = {
    "motors run at first": "the motors are off at first",
    "servos pulse at first": "the servos have no pulse at first",
    "clock goes back": "the clock goes on",
    "clock jumps": "the clock goes on",
    "clock is slow": "the clock goes on",
    "clock waits for the line": "the clock goes on under load",
    "noise is constant": "noise differs",
    "read waits": "no call waits",
    "buffer is small": "bytes are kept in their order",
    "bytes come backward": "bytes are kept in their order",
    "bytes are made up": "bytes are kept in their order",
    "room is small": "reports are sent whole",
    "bytes are lost": "reports are sent whole",
    "bytes are damaged": "reports are sent whole",
    "motor is late": "motors follow",
    "motor is reversed": "motors follow",
    "motors are swapped": "motors follow",
    "back motors are swapped": "motors follow",
    "motor is weak": "motors follow",
    "motor does not brake": "motors follow",
    "motor falls asleep": "motors hold",
    "pulses are wide": "servos follow",
    "pulses are rare": "servos follow",
    "pulses do not end": "servos follow",
    "servos are swapped": "servos follow",
    "pulses twitch": "servos do not twitch",
    "battery is half": "the battery is in proportion",
    "battery has 16 bits": "the battery is in proportion",
    "bumper sticks": "bumpers are felt",
    "ticks are lost": "ticks are counted",
    "ticks count up only": "ticks are counted",
    "ticks are made up": "ticks are counted",
    "watchdog is hasty": "a living program is left alone",
    "watchdog sleeps": "a program that hangs is restarted",
    "watchdog is slow": "a program that hangs is restarted",
    "restarts with power": "a program that hangs is restarted",
}
"""The possible faults of a board, each with the promise that notices it first."""


@cache
def program() -> Path:
    built = subprocess.run(
        ["sh", ".make/firmware.sh", "port"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert built.returncode == 0, built.stderr
    return Path(built.stdout.splitlines()[-1])


def run(*words: str) -> tuple[int, list[str]]:
    done = subprocess.run(
        [program(), *words], capture_output=True, text=True, timeout=60, check=False
    )
    return done.returncode, done.stdout.splitlines()


def test_a_board_that_keeps_all_promises_passes() -> None:
    """Each promise is tested and kept, even past the end of the board's clock."""
    status, lines = run()
    assert status == 0, lines
    assert {line.split(" - ")[0] for line in lines} == {"ok"}
    assert {line.split(" - ")[1] for line in lines} >= set(BROKEN.values())
    assert "ok - the program drives and stops" in lines
    assert "ok - the program moves sideways and stops" in lines


def test_every_fault_of_the_made_up_board_is_here() -> None:
    """No fault is left untried."""
    assert sorted(run("--faults")[1]) == sorted(BROKEN)


@pytest.mark.parametrize("fault", BROKEN)
def test_a_board_with_a_fault_is_found_out(fault: str) -> None:
    """The promise that it breaks is the first reported as broken, with what was seen."""
    status, lines = run("--fault", fault)
    assert status == 1
    broken = [line.removeprefix("BROKEN - ") for line in lines if line.startswith("BROKEN - ")]
    assert broken[0].split(": ")[0] == BROKEN[fault], broken
    assert len(broken[0].split(": ")[1]) > 5


def test_what_a_bench_cannot_see_is_not_called_kept() -> None:
    """It is reported as not tested; everything that needs no eyes is still tested."""
    status, lines = run("--blind")
    assert status == 0
    kept = [line for line in lines if line.startswith("ok - ")]
    assert kept == ["ok - the clock goes on", "ok - noise differs", "ok - no call waits"]
    assert all(line.startswith("not tested - ") for line in lines if line not in kept)


def test_a_fault_that_there_is_not_is_refused() -> None:
    """A typing error must not pass for a good board."""
    assert run("--fault", "no such fault")[0] == 2
