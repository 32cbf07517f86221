"""Runs a module of ours in a process of its own, which is controlled by lines of text."""

from __future__ import annotations

import asyncio
import sys
from asyncio.subprocess import PIPE
from contextlib import asynccontextmanager, suppress
from typing import TYPE_CHECKING, Final

from e2e.measure.errors import MeasureError
from e2e.measure.suite import ROOT

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from collections.abc import AsyncIterator, Callable

_LATEST_S: Final = 60.0
_LONGEST_LINE_BYTES: Final = 1 << 20


async def kill(process: Process | None) -> None:
    """End a process as a power cut does; safe to call twice, and with None."""
    if process is not None and process.returncode is None:
        with suppress(ProcessLookupError):
            process.kill()
        await process.wait()


async def terminate(process: Process) -> None:
    """Ask a process to end, if it has not, and wait until it has."""
    if process.returncode is None:
        process.terminate()
    await process.wait()


async def ends(process: Process, within_s: float) -> None:
    """Wait until a process that was asked to end has ended; kill it if it is too slow."""
    with suppress(TimeoutError):
        await asyncio.wait_for(process.wait(), within_s)
    await kill(process)


class Child:
    def __init__(self, process: Process) -> None:
        self.pid = process.pid
        self._process = process

    async def line(self, within_s: float = _LATEST_S) -> bytes:
        """Return its next line; raises `MeasureError` if it has ended."""
        assert self._process.stdout is not None
        said = await asyncio.wait_for(self._process.stdout.readline(), within_s)
        if not said:
            raise MeasureError("a process ended too soon; its last words are above")
        return said

    async def say(self, text: str) -> None:
        assert self._process.stdin is not None
        with suppress(ConnectionError):  # its readers learn that it has ended
            self._process.stdin.write(text.encode() + b"\n")
            await self._process.stdin.drain()


@asynccontextmanager
async def child(
    module: str,
    *arguments: object,
    leaves_s: float = 0.0,
    through: Callable[[list[str]], list[str]] = list,
) -> AsyncIterator[Child]:
    """Run it inside the block; then close its input, and kill it after `leaves_s`.

    `through` turns its command line into one that runs it elsewhere.
    """
    command = through([sys.executable, "-m", module, *map(str, arguments)])
    process = await asyncio.create_subprocess_exec(
        *command, stdin=PIPE, stdout=PIPE, cwd=ROOT, limit=_LONGEST_LINE_BYTES
    )
    try:
        yield Child(process)
    finally:
        assert process.stdin is not None
        process.stdin.close()
        await ends(process, leaves_s)
