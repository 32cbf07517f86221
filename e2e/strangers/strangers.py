"""Strangers in a process of their own, and the loopback addresses that they come from."""

from __future__ import annotations

import asyncio
import json
import sys
from contextlib import asynccontextmanager
from subprocess import PIPE
from typing import TYPE_CHECKING, Any, Final

from e2e.measure.errors import MeasureError, NotRunError
from e2e.measure.suite import ROOT

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

_LATEST_S: Final = 60.0


def address(number: int) -> str:
    """Return one of the loopback addresses that nothing else uses, from 0."""
    return f"127.0.{1 + number // 250}.{2 + number % 250}"


def needs_loopback_net() -> None:
    """Raise `NotRunError` where only 127.0.0.1 is the loopback, as on macOS."""
    if sys.platform != "linux":
        raise NotRunError("this needs the whole of 127.0.0.0/8, which only Linux has")


@asynccontextmanager
async def strangers(module: str, *arguments: object) -> AsyncIterator[Strangers]:
    """Run one of the modules of this folder; it has begun when the block begins."""
    needs_loopback_net()
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", f"e2e.strangers.{module}", *map(str, arguments)),
        stdin=PIPE,
        stdout=PIPE,
        cwd=ROOT,
    )
    found = Strangers(process)
    try:
        await found.line()
        yield found
    finally:
        if process.returncode is None:
            process.kill()
            await process.wait()


class Strangers:
    """Their process: says an empty line when it begins, and JSON when it ends."""

    def __init__(self, process: asyncio.subprocess.Process) -> None:
        self._process = process

    async def line(self, within_s: float = _LATEST_S) -> bytes:
        """Return its next line; raises `MeasureError` if it has ended."""
        assert self._process.stdout is not None
        said = await asyncio.wait_for(self._process.stdout.readline(), within_s)
        if not said:
            raise MeasureError("the strangers ended too soon; their last words are above")
        return said

    async def say(self, text: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(text.encode() + b"\n")
        await self._process.stdin.drain()

    async def account(self, within_s: float = _LATEST_S) -> dict[str, Any]:
        """Return what it says at its end."""
        found: dict[str, Any] = json.loads(await self.line(within_s))
        return found
