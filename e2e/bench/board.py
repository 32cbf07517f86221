"""The robot's end of the serial line: the real firmware's core behind a pseudo-terminal.

It runs in a process of its own, because a busy thread next door would make bytes look late.
"""

from __future__ import annotations

import json
import subprocess
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from e2e.bench.errors import BenchError

if TYPE_CHECKING:
    from types import TracebackType

ROOT = Path(__file__).resolve().parents[2]
START_TIMEOUT_S = 10.0


class Board:
    """`with Board() as board:` — `board.url` is for the server, `board.finish()` tells all."""

    def __init__(self) -> None:
        built = subprocess.run(
            ["sh", ".make/firmware.sh", "board"],
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=False,
        )
        if built.returncode:
            raise BenchError(f"the firmware was not built: {built.stderr.strip()}")
        self._folder = TemporaryDirectory()
        port, self._log = (Path(self._folder.name) / name for name in ("port", "board.jsonl"))
        self.url = str(port)
        self._process = subprocess.Popen(
            [built.stdout.splitlines()[-1], "--link", self.url, "--log", str(self._log)],
            stdin=subprocess.PIPE,
        )
        end_s = time.monotonic() + START_TIMEOUT_S
        while not port.exists():
            if self._process.poll() is not None or time.monotonic() > end_s:
                raise BenchError("the board does not start")
            time.sleep(0.01)

    def __enter__(self) -> Board:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._process.kill()
        self._process.communicate()
        self._folder.cleanup()

    def finish(self) -> list[dict[str, Any]]:
        """Return its log, oldest first, and end it; ``t_s`` is CLOCK_MONOTONIC."""
        self._process.communicate(b"quit\n", timeout=START_TIMEOUT_S)
        return [json.loads(line) for line in self._log.read_text().splitlines()]
