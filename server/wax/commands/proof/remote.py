"""Controls an operator's process, which can be given orders, frozen and killed."""

from __future__ import annotations

import asyncio
import contextlib
import json
import sys
import uuid
from typing import TYPE_CHECKING, Final

from wax.client.process import OperatorState
from wax.commands.proof.controlled_process import ControlledProcess
from wax.errors import StartError

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from collections.abc import Callable
    from pathlib import Path

    from wax.client.process import Order

_OPEN_S: Final = 30.0


class RemoteOperator(ControlledProcess):
    """`state` is the newest state that the operator reported; `on_state` gets each."""

    def __init__(self, log: Path, on_state: Callable[[OperatorState], None] | None = None) -> None:
        super().__init__(log)
        self.state = OperatorState()
        self._on_state = on_state
        self._client_id = str(uuid.uuid4())
        self._cookies = log.with_suffix(".cookies")
        self._hearing: asyncio.Task[None] | None = None
        self._changed = asyncio.Event()

    async def start(self, url: str) -> None:
        """Start it and wait until it is connected; raises `StartError`."""
        process = await self.spawn(
            *(sys.executable, "-m", "wax.client.process", url, self._client_id, str(self._cookies)),
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
        )
        self.state = OperatorState()
        self._hearing = asyncio.create_task(self._hear(process), name="operator")
        if not await self.until(lambda: self.state.is_open, _OPEN_S):
            raise StartError(f"the proof's operator cannot connect: {self.last_line()}")

    def send(self, order: Order) -> None:
        if self._process is not None and self._process.stdin is not None:
            self._process.stdin.write(order.encode() + b"\n")

    async def kill(self) -> None:
        await super().kill()
        if self._hearing is not None:
            await asyncio.gather(self._hearing, return_exceptions=True)

    async def until(self, holds: Callable[[], bool], within_s: float) -> bool:
        """Wait until a new state makes `holds` true; False on timeout or if the process ended."""
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
                self.state = OperatorState(**json.loads(line))
                if self._on_state is not None:
                    self._on_state(self.state)
                self._changed.set()
        finally:
            self.state = OperatorState()
            self._changed.set()
