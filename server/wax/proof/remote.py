"""The proof's hand on its operator: a process that can be told, frozen and killed."""

from __future__ import annotations

import asyncio
import contextlib
import json
import signal
import sys
from typing import TYPE_CHECKING, Final

from wax.errors import StartError
from wax.proof.operator import Seat

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from pathlib import Path

    from wax.proof.operator import Order

_OPEN_S: Final = 30.0


class RemoteOperator:
    """`seat` is the newest that the operator has told; `log` takes his complaints."""

    def __init__(self, log: Path) -> None:
        self.seat = Seat()
        self._log = log
        self._process: Process | None = None
        self._hearing: asyncio.Task[None] | None = None
        self._changed = asyncio.Event()

    async def start(self, url: str) -> None:
        """Start it and wait until it is connected; raises `StartError`."""
        with self._log.open("ab") as log:
            self._process = await asyncio.create_subprocess_exec(
                *(sys.executable, "-m", "wax.proof.operator", url),
                stdin=asyncio.subprocess.PIPE,
                stdout=asyncio.subprocess.PIPE,
                stderr=log,
                start_new_session=True,  # Ctrl-C is for the proof, which ends it in its order
            )
        self.seat = Seat()
        self._hearing = asyncio.create_task(self._hear(self._process), name="operator")
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(_OPEN_S):
                while not self.seat.is_open and not self._hearing.done():
                    await self._next()
        if not self.seat.is_open:
            raise StartError(f"the proof's operator cannot connect: {self._last_line()}")

    def tell(self, order: Order) -> None:
        if self._process is not None and self._process.stdin is not None:
            self._process.stdin.write(order.encode() + b"\n")

    def freeze(self) -> None:
        """Let nothing leave it from now on."""
        self._signal(signal.SIGSTOP)

    def thaw(self) -> None:
        self._signal(signal.SIGCONT)

    async def end(self) -> None:
        """End it, frozen or not; safe to call twice."""
        process, self._process = self._process, None
        if process is None:
            return
        with contextlib.suppress(ProcessLookupError):
            process.kill()
        await process.wait()
        if process.stdin is not None:
            process.stdin.close()
        if self._hearing is not None:
            await asyncio.gather(self._hearing, return_exceptions=True)

    async def _next(self) -> None:
        self._changed.clear()
        await self._changed.wait()

    async def _hear(self, process: Process) -> None:
        assert process.stdout is not None
        try:
            async for line in process.stdout:
                self.seat = Seat(**json.loads(line))
                self._changed.set()
        finally:
            self.seat = Seat()
            self._changed.set()

    def _last_line(self) -> str:
        said = self._log.read_text(encoding="utf-8", errors="replace").strip()
        return said.rpartition("\n")[2] or "it said nothing"

    def _signal(self, number: signal.Signals) -> None:
        if self._process is not None:
            with contextlib.suppress(ProcessLookupError):
                self._process.send_signal(number)
