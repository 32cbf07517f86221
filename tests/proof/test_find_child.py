"""Finding the process that speaks with the robot."""

from __future__ import annotations

import os
import subprocess
import sys

from wax.proof.server import find_child, kill


def test_a_child_is_found_by_a_word_of_its_command_line() -> None:
    """Of our children the one with this word is found, and nobody else's; killed, it is gone."""
    sleep = "import time; time.sleep(60)  # a-word-of-its-own"
    with subprocess.Popen((sys.executable, "-c", sleep)) as child:
        try:
            assert find_child(os.getpid(), "a-word-of-its-own") == child.pid
            assert find_child(os.getpid(), "another-word") is None
            assert find_child(child.pid, "a-word-of-its-own") is None
        finally:
            kill(child.pid)
    assert find_child(os.getpid(), "a-word-of-its-own") is None
    kill(child.pid)
