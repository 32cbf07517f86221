"""A child process of the proof that can be frozen, thawed and killed."""

from __future__ import annotations

import asyncio
import contextlib
import signal
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from pathlib import Path


class ControlledProcess:
    """A process whose standard error goes to `log`."""

    def __init__(self, log: Path) -> None:
        self._log = log
        self._process: Process | None = None

    async def spawn(self, *command: str, stdin: int, stdout: int | None = None) -> Process:
        """Start it; `kill` ends it. Without `stdout` its output goes to the log."""
        with self._log.open("ab") as log:
            self._process = await asyncio.create_subprocess_exec(
                *command,
                stdin=stdin,
                stdout=log if stdout is None else stdout,
                stderr=log,
                start_new_session=True,  # Ctrl-C is for the proof, which ends it in order
            )
        return self._process

    @property
    def runs(self) -> bool:
        """It was started and not killed since; it may have ended by itself."""
        return self._process is not None

    def freeze(self) -> None:
        """Freeze this process alone, not its children."""
        self._signal(signal.SIGSTOP)

    def thaw(self) -> None:
        self._signal(signal.SIGCONT)

    async def kill(self) -> None:
        """Kill it, frozen or not; safe to call twice."""
        process, self._process = self._process, None
        if process is None:
            return
        with contextlib.suppress(ProcessLookupError):
            process.kill()
        await process.wait()
        if process.stdin is not None:
            process.stdin.close()

    def last_line(self) -> str:
        """Return the last line of its log."""
        said = self._log.read_text(encoding="utf-8", errors="replace").strip()
        return said.rpartition("\n")[2] or "it logged nothing"

    def _signal(self, number: signal.Signals) -> None:
        if self._process is not None:
            with contextlib.suppress(ProcessLookupError):
                self._process.send_signal(number)
