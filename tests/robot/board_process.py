"""A board in a process of its own, and the driver at its port."""

from __future__ import annotations

import json
import subprocess
import time
from typing import TYPE_CHECKING, Any, ClassVar

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from wax.robot.serial.driver import SerialRobot


class BoardProcess:
    """Takes commands as lines of its input, and logs events as lines of JSON."""

    driver: SerialRobot
    patience_s: ClassVar = 10.0

    def __init__(self, command: Sequence[str], folder: Path) -> None:
        self._log = folder / "log"
        self.port = folder / "port"
        self._process = subprocess.Popen(
            [*command, str(self.port), str(self._log)],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
        )

    def end(self) -> None:
        self.driver.close()
        assert self._process.stdin is not None
        self._process.stdin.close()
        assert self._process.wait(5) == 0

    def write(self, command: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(f"{command}\n".encode())
        self._process.stdin.flush()

    def all(self, event: str, since_s: float = 0.0) -> list[dict[str, Any]]:
        text = self._log.read_text(encoding="utf-8") if self._log.exists() else ""
        found = [json.loads(line) for line in text.splitlines(keepends=True) if line.endswith("\n")]
        return [one for one in found if one["event"] == event and one["t_s"] >= since_s]

    def newest(self, event: str) -> tuple[int, int]:
        """Return the left and the right wheel's newest value, 0 before the first."""
        turned = self.all(event)
        return (turned[-1]["left"], turned[-1]["right"]) if turned else (0, 0)

    def wait_until(self, so: Callable[[], bool], what: str = "it is so") -> None:
        end_s = time.monotonic() + self.patience_s
        while not so():
            assert time.monotonic() < end_s, f"never: {what}; {self._log.read_text()[-2000:]}"
            time.sleep(0.01)
