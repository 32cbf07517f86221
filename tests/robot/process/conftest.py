"""A driver process with a robot that logs its calls and their times."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

import pytest
from tests.until import until

from wax.config.local import LocalSettings
from wax.config.robot import RobotSettings
from wax.config.serial import SerialSettings

if TYPE_CHECKING:
    import signal
    from collections.abc import Iterator
    from pathlib import Path


@dataclass(frozen=True)
class Entry:
    at_s: float
    word: str
    values: tuple[float, ...]

    @property
    def is_motion(self) -> bool:
        return self.word == "axis" or (self.word == "apply" and any(self.values[:3]))


class Log:
    """The recorder's log so far."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def entries(self, since_s: float = 0.0) -> list[Entry]:
        if not self._path.exists():
            return []
        whole, _, _ = self._path.read_text().rpartition("\n")
        split = [line.split() for line in whole.splitlines()]
        found = [Entry(float(at), word, tuple(map(float, v))) for at, word, *v in split]
        return [entry for entry in found if entry.at_s >= since_s]

    def moves(self, since_s: float = 0.0) -> bool:
        return any(entry.is_motion for entry in self.entries(since_s))

    def stopped_s(self, since_s: float) -> float:
        """Wait for the first stop since then, and return its time."""
        until(lambda: any(entry.word == "stop" for entry in self.entries(since_s)))
        return next(entry.at_s for entry in self.entries(since_s) if entry.word == "stop")

    def pid(self) -> int:
        """Return the PID of the process that last opened the robot."""
        return int([entry.values[0] for entry in self.entries() if entry.word == "open"][-1])


def is_alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


class Server:
    """The process that holds the robot: `tests.robot.process.parent`."""

    def __init__(
        self,
        settings: RobotSettings,
        log: Log,
        *,
        stderr: int | None = None,
        local: LocalSettings | None = None,
        claim: str = "",
    ) -> None:
        local = local or LocalSettings()
        arguments = (settings.model_dump_json(), local.model_dump_json(), claim)
        self.process = subprocess.Popen(
            [sys.executable, "-m", "tests.robot.process.parent", *arguments],
            stdin=subprocess.PIPE,
            stderr=stderr,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
            start_new_session=True,  # a terminal's foreground group
        )
        self.log = log

    def send(self, word: str) -> float:
        """Send it an order; return when."""
        assert self.process.stdin is not None
        now_s = time.monotonic()
        self.process.stdin.write(word.encode() + b"\n")
        self.process.stdin.flush()
        return now_s

    def drive(self) -> None:
        """Let it drive, starting with the required standstill."""
        until(lambda: any(entry.word == "apply" for entry in self.log.entries()))
        until(self._drives_off)

    def _drives_off(self) -> bool:
        """Try once; on a busy machine the server may be silent for too long."""
        self.send("stand")
        time.sleep(0.1)
        since_s = self.send("drive")
        time.sleep(0.1)
        return self.log.moves(since_s)

    def signal(self, number: signal.Signals) -> float:
        """Send a signal; return when."""
        now_s = time.monotonic()
        os.kill(self.process.pid, number)
        return now_s

    def end(self) -> None:
        self.process.kill()
        self.process.wait()
        assert self.process.stdin is not None
        self.process.stdin.close()


@pytest.fixture
def log(tmp_path: Path) -> Log:
    return Log(tmp_path / "log")


def settings_for(log: Log, name: str = "Recorder", silence_ms: int = 120) -> RobotSettings:
    return RobotSettings(
        driver=f"tests.robot.process.recorder:{name}",
        silence_ms=silence_ms,
        serial=SerialSettings(url=str(log._path)),
    )


@pytest.fixture
def server(log: Log) -> Iterator[Server]:
    """Start a server whose robot stands."""
    server = Server(settings_for(log), log)
    yield server
    server.end()
