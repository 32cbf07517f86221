"""The driver process as its parent sees it: two pipes that never block, and an exit status."""

from __future__ import annotations

import os
import select
import subprocess
from typing import TYPE_CHECKING, Final

from wax.machine import python_module

if TYPE_CHECKING:
    from collections.abc import Collection

_READ_BYTES: Final = 65_536
_END_S: Final = 0.5
_DRIVER: Final = "wax.robot.process"


class ChildProcess:
    """Starts the process and sends it `begin`; raises `OSError` if it cannot be started.

    It runs `module`, and inherits `descriptors`. Do not call `send`, `hang_up` or `kill` after
    `end`.
    """

    def __init__(
        self, begin: bytes, module: str = _DRIVER, descriptors: Collection[int] = ()
    ) -> None:
        self._process = subprocess.Popen(
            python_module.command(module),
            pass_fds=descriptors,
            bufsize=0,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=python_module.environment(),
            # Ctrl-C reaches all processes of the terminal; this one must stop the robot first.
            start_new_session=True,
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._stdin, self._stdout = self._process.stdin, self._process.stdout
        os.set_blocking(self._stdin.fileno(), False)
        os.set_blocking(self._stdout.fileno(), False)
        self._news = select.poll()
        self._news.register(self._stdout.fileno(), select.POLLIN)
        self.send(begin)

    @property
    def pid(self) -> int:
        return self._process.pid

    def send(self, line: bytes) -> bool:
        """Send a line; False if the pipe is full. Only `receive` reports that it has ended."""
        if self._stdin.closed:
            return True
        try:
            return self._stdin.write(line) == len(line)
        except BrokenPipeError:
            return True

    def receive(self, timeout_s: float) -> bytes | None:
        """Return what it has sent, empty after a timeout, None when it has ended."""
        if not self._news.poll(max(0.0, timeout_s) * 1000.0):
            return b""
        return self._stdout.read(_READ_BYTES) or None

    def hang_up(self) -> None:
        """Close the pipe, which makes the process stop the robot and end; safe to call twice."""
        self._stdin.close()

    def kill(self) -> None:
        """Kill it at once; then the robot's own watchdog stops the robot."""
        self._process.kill()

    def end(self) -> int:
        """Hang up, wait briefly, kill it, and return its exit status, negative for a signal."""
        self.hang_up()
        try:
            return self._process.wait(_END_S)
        except subprocess.TimeoutExpired:
            self.kill()
            return self._process.wait()
        finally:
            self._stdout.close()
