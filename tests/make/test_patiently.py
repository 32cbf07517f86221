"""Commands that talk to mirrors: bounded in time, tried again, nothing left behind."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

import patiently

if TYPE_CHECKING:
    import pytest

SCRIPT = str(Path(patiently.__file__))


def test_a_command_that_hangs_is_ended_with_its_children() -> None:
    """The limit holds for the whole process group: a child keeps no pipe open."""
    began_s = time.monotonic()
    hanging = [sys.executable, SCRIPT, "0.3", "1", "sh", "-c", "sleep 30 & sleep 30"]
    ended = subprocess.run(hanging, stdout=subprocess.PIPE, check=False, timeout=10)
    assert ended.returncode == patiently.TIMED_OUT
    assert time.monotonic() - began_s < 5


def test_a_command_that_fails_is_tried_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The second try may succeed; a person is told why it took longer."""
    flag = tmp_path / "tried"
    command = ["sh", "-c", f"test -e {flag} || {{ touch {flag}; exit 7; }}"]
    assert patiently.insist(10, 3, command, sleep=lambda _: None) == 0
    assert "failed (7); trying again" in capsys.readouterr().err


def test_a_command_that_always_fails_gives_its_status() -> None:
    """After the last try the status is the command's own."""
    waits_s: list[float] = []
    assert patiently.insist(10, 3, ["sh", "-c", "exit 7"], sleep=waits_s.append) == 7
    assert waits_s == [2, 4]


def test_a_command_that_does_not_exist_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    """As in a shell the status is 127, and it is not tried again."""
    assert patiently.insist(10, 3, ["/nonexistent/npm"]) == 127
    assert "/nonexistent/npm" in capsys.readouterr().err
