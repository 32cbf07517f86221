"""The standby as the driver sees it, played by programs of a few lines."""

from __future__ import annotations

import subprocess
import time
from typing import TYPE_CHECKING, Any, Final

import pytest
from tests.robot.ros2.robots import ros2_settings

from wax.clock import SystemClock
from wax.robot.ros2 import standby_process
from wax.robot.ros2.settings import Ros2Settings
from wax.robot.ros2.standby_process import STARTS, StandbyProcess

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from wax.sentence import Sentence

pytestmark = pytest.mark.system

_LIVES: Final = """
import sys, time
sys.stdin.readline()
while True:
    print("me 1", flush=True)
    time.sleep(0.05)
"""
_TRACES: Final = r"""
import sys, time
sys.stdin.readline()
print("trace", flush=True)
time.sleep(0.2)
sys.stdout.buffer.write(b"me 1\n\n1 2 3\nme many\n\xff\xfe 7\n")
sys.stdout.flush()
time.sleep(0.3)
"""


@pytest.fixture
def play(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[str], StandbyProcess]]:
    """Return what makes a standby of a program's text."""
    made: list[StandbyProcess] = []

    def play(program: str) -> StandbyProcess:
        monkeypatch.setattr(standby_process, "_COMMAND", ("-c", program))
        own = ros2_settings(0).own(Ros2Settings)
        made.append(StandbyProcess(own, SystemClock()))
        return made[-1]

    yield play
    for standby in made:
        process = standby._process
        standby.leave()
        if process is not None:
            process.kill()


def until(standby: StandbyProcess, said: Sentence | None, within_s: float = 10.0) -> None:
    end_s = time.monotonic() + within_s
    while standby.look() != said:
        assert time.monotonic() < end_s
        time.sleep(0.02)


def test_what_a_library_prints_says_nothing(play: Callable[[str], StandbyProcess]) -> None:
    """Lines that are not the standby's own neither raise nor change what it said."""
    standby = play(_TRACES)
    until(standby, None)
    assert standby.guid == "me"


def test_one_that_ends_at_once_is_no_error(
    play: Callable[[str], StandbyProcess], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A standby that has ended before it was told its settings is only not there."""

    def ended(*args: Any, **how: Any) -> subprocess.Popen[bytes]:
        process = real(*args, **how)
        process.wait(10)
        return process

    real = subprocess.Popen
    monkeypatch.setattr(subprocess, "Popen", ended)
    standby = play("")
    assert standby.look() == STARTS
    standby.tell(owes=True)
    assert standby.look() == STARTS
