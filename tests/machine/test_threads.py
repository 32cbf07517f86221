"""The check for enough threads, in a child process with a limit."""

from __future__ import annotations

import subprocess
import sys

import pytest

from wax.__main__ import main
from wax.machine import threads

LIMITED = """
import os, resource, sys
from wax.machine.threads import SERVERS, problem
if os.geteuid() == 0:
    os.setuid(61234)  # root is not limited
resource.setrlimit(resource.RLIMIT_NPROC, (int(sys.argv[1]),) * 2)
print(problem(SERVERS))
"""


@pytest.mark.system
@pytest.mark.skipif(sys.platform != "linux", reason="its kernel counts threads as processes")
def test_a_limit_is_a_sentence() -> None:
    """The sentence says how many more threads may start; none is left running."""
    command = [sys.executable, "-c", LIMITED]
    told = subprocess.run([*command, "1"], capture_output=True, text=True, check=True)
    assert told.stdout.startswith("This user may start 0 threads more, and WAX takes 32.")
    assert not told.stderr


def test_without_a_limit_there_is_nothing_to_say() -> None:
    """Without a limit, all threads start and there is no problem."""
    assert threads.problem(threads.SERVERS) == ""


@pytest.mark.parametrize("command", ["run", "doctor"])
def test_it_is_told_before_a_library_stumbles(
    command: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The server and the doctor end with the sentence and advice, without a traceback."""
    monkeypatch.setattr(threads, "problem", lambda _: "No more threads.")
    assert main([command]) == 1
    assert capsys.readouterr().err == f"wax: No more threads. {threads.ADVICE}\n"
