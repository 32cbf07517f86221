"""`wax replay` around a block."""

from __future__ import annotations

import asyncio
import os
import signal
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from e2e.harness.server import COMMAND, free_port

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path


@asynccontextmanager
async def replayed(folder: Path) -> AsyncIterator[str]:
    """Run it on this machine; gives the URL of its page."""
    port = free_port()
    process = await asyncio.create_subprocess_exec(
        str(COMMAND),
        "replay",
        str(folder),
        "--port",
        str(port),
        stdout=asyncio.subprocess.PIPE,
        env=os.environ,
    )
    assert process.stdout is not None
    try:
        async with asyncio.timeout(20):
            while b"http://" not in (line := await process.stdout.readline()):
                assert line, "wax replay has ended"
        yield line.decode().split()[-1]
        process.send_signal(signal.SIGTERM)
        assert await asyncio.wait_for(process.wait(), 5) == 0
    finally:
        if process.returncode is None:
            process.kill()
            await process.wait()
