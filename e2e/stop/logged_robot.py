"""The serial robot with a log of what its driver is told, an ordinary plug-in.

The environment names the file. Each line is a call: when by ``time.monotonic``, ``apply`` with both
speeds, or ``stop``.
"""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from wax.robot.serial.driver import SerialRobot

if TYPE_CHECKING:
    from pathlib import Path

    from wax.clock import Clock
    from wax.config.settings import RobotSettings
    from wax.driver.interface import Twist

CALLS: Final = "WAX_FAULTS_CALLS"
PLUG_IN: Final = {"robot": {"driver": "e2e.stop.logged_robot:LoggedRobot"}}


class LoggedRobot(SerialRobot):
    """Writes each call down before it is done, in one write."""

    def __init__(self, settings: RobotSettings, clock: Clock) -> None:
        super().__init__(settings, clock)
        self._file: int | None = None

    def open(self) -> None:
        self._file = os.open(os.environ[CALLS], os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600)
        super().open()

    def apply(self, twist: Twist, turn: int) -> None:
        self._log(f"apply {twist.linear_mps} {twist.angular_rps}")
        super().apply(twist, turn)

    def stop(self, turn: int) -> None:
        self._log("stop 0 0")
        super().stop(turn)

    def close(self) -> None:
        super().close()
        file, self._file = self._file, None
        if file is not None:
            os.close(file)

    def _log(self, call: str) -> None:
        if self._file is not None:
            os.write(self._file, f"{time.monotonic():.6f} {call}\n".encode())


@dataclass(frozen=True, slots=True)
class Call:
    """A call of the driver; `linear_mps` is 0 for a stop."""

    at_s: float
    word: str
    linear_mps: float


class Calls:
    """The calls so far; `since` reads what is new."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._offset = 0
        self._half = b""
        self._calls: list[Call] = []

    def since(self, since_s: float) -> list[Call]:
        """Return the calls after that moment, oldest first; forgets those before it."""
        with self._path.open("rb") as log:
            log.seek(self._offset)
            data = log.read()
        self._offset += len(data)
        *lines, self._half = (self._half + data).split(b"\n")
        for line in lines:
            at_s, word, linear_mps, _ = line.decode().split()
            self._calls.append(Call(float(at_s), word, float(linear_mps)))
        self._calls = [call for call in self._calls if call.at_s > since_s]
        return self._calls
