"""A server in a process of its own, as a service manager runs it."""

from __future__ import annotations

import asyncio
import os
import sys
import time
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

import aiohttp

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from collections.abc import AsyncIterator, Mapping
    from pathlib import Path

START_S = 30.0
STOP_WITHIN_S = 3.0


@asynccontextmanager
async def serving(
    config: Path,
    port: int,
    *,
    environment: Mapping[str, str] | None = None,
    command: tuple[str, ...] = (sys.executable, "-m", "wax"),
) -> AsyncIterator[Process]:
    """Run the server around a block, on the loopback interface; kill it if it is still there.

    The files that survive it are next to its configuration.
    """
    process = await asyncio.create_subprocess_exec(
        *command,
        *("--config", str(config), "--host", "127.0.0.1", "--port", str(port)),
        *("--udp-port", "0"),
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.DEVNULL,
        env={**os.environ, "XDG_STATE_HOME": str(config.parent), **(environment or {})},
    )
    try:
        yield process
    finally:
        if process.returncode is None:
            process.kill()
        await process.wait()


async def answers(port: int, process: Process) -> None:
    """Wait until `/healthz` answers; raises `AssertionError` if the process ends before."""
    deadline_s = time.monotonic() + START_S
    async with aiohttp.ClientSession() as http:
        while time.monotonic() < deadline_s:
            assert process.returncode is None, f"it ended with {process.returncode}"
            try:
                async with http.get(f"http://127.0.0.1:{port}/healthz") as response:
                    if response.status == 200:
                        return
            except aiohttp.ClientError:
                pass
            await asyncio.sleep(0.05)
    raise AssertionError(f"no answer on port {port} within {START_S:g} s")


"""A third of the TimeoutStopSec of `config/deploy/wax.service`."""
