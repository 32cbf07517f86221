"""The near end of an operator's process, which can be told, frozen and killed."""

from __future__ import annotations

import asyncio
import contextlib
import json
import sys
import uuid
from typing import TYPE_CHECKING, Final

from wax.client.process import Seat
from wax.errors import StartError
from wax.proof.controlled_process import ControlledProcess

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from collections.abc import Callable
    from pathlib import Path

    from wax.client.process import Order

_OPEN_S: Final = 30.0


class RemoteOperator(ControlledProcess):
    """`seat` is the newest that the operator has told; `on_seat` gets each."""

    def __init__(self, log: Path, on_seat: Callable[[Seat], None] | None = None) -> None:
        super().__init__(log)
        self.seat = Seat()
        self._on_seat = on_seat
        self._client_id = str(uuid.uuid4())
        self._hearing: asyncio.Task[None] | None = None
        self._changed = asyncio.Event()

    async def start(self, url: str) -> None:
        """Start it and wait until it is connected; raises `StartError`."""
        process = await self.spawn(
            *(sys.executable, "-m", "wax.client.process", url, self._client_id),
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
        )
        self.seat = Seat()
        self._hearing = asyncio.create_task(self._hear(process), name="operator")
        if not await self.until(lambda: self.seat.is_open, _OPEN_S):
            raise StartError(f"the proof's operator cannot connect: {self.last_line()}")

    def tell(self, order: Order) -> None:
        if self._process is not None and self._process.stdin is not None:
            self._process.stdin.write(order.encode() + b"\n")

    async def kill(self) -> None:
        await super().kill()
        if self._hearing is not None:
            await asyncio.gather(self._hearing, return_exceptions=True)

    async def until(self, holds: Callable[[], bool], within_s: float) -> bool:
        """Wait for what a new seat brings about; False where none did in time, or it has ended."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(within_s):
                while not holds() and self._hearing is not None and not self._hearing.done():
                    self._changed.clear()
                    await self._changed.wait()
        return holds()

    async def _hear(self, process: Process) -> None:
        assert process.stdout is not None
        try:
            async for line in process.stdout:
                self.seat = Seat(**json.loads(line))
                if self._on_seat is not None:
                    self._on_seat(self.seat)
                self._changed.set()
        finally:
            self.seat = Seat()
            self._changed.set()
