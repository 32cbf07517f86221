"""The proof's hand on its operator: a process that can be told, frozen and killed."""

from __future__ import annotations

import asyncio
import contextlib
import json
import sys
from typing import TYPE_CHECKING, Final

from wax.errors import StartError
from wax.proof.operator import Seat
from wax.proof.puppet import Puppet

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from pathlib import Path

    from wax.proof.operator import Order

_OPEN_S: Final = 30.0


class RemoteOperator(Puppet):
    """`seat` is the newest that the operator has told."""

    def __init__(self, log: Path) -> None:
        super().__init__(log)
        self.seat = Seat()
        self._hearing: asyncio.Task[None] | None = None
        self._changed = asyncio.Event()

    async def start(self, url: str) -> None:
        """Start it and wait until it is connected; raises `StartError`."""
        process = await self.spawn(
            *(sys.executable, "-m", "wax.proof.operator", url),
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
        )
        self.seat = Seat()
        self._hearing = asyncio.create_task(self._hear(process), name="operator")
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(_OPEN_S):
                while not self.seat.is_open and not self._hearing.done():
                    await self._next()
        if not self.seat.is_open:
            raise StartError(f"the proof's operator cannot connect: {self.last_line()}")

    def tell(self, order: Order) -> None:
        if self._process is not None and self._process.stdin is not None:
            self._process.stdin.write(order.encode() + b"\n")

    async def kill(self) -> None:
        await super().kill()
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
