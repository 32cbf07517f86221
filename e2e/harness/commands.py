"""The commands that people type next to a server, such as `wax host-link` and `wax replay`."""

from __future__ import annotations

import asyncio
import os
import re
import signal
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from tests.free_port import free_port

from e2e.harness.child import kill
from e2e.harness.server import COMMAND

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer


async def said_by(folder: Path, *words: str, **environment: str) -> str:
    """Run a command next to the server configured in this folder; return what it prints."""
    process = await asyncio.create_subprocess_exec(
        *(str(COMMAND), *words, "--config", str(folder / "wax.toml")),
        stdout=asyncio.subprocess.PIPE,
        env=os.environ | environment,
    )
    said, _ = await process.communicate()
    assert process.returncode == 0
    return said.decode()


async def become_host(viewer: Viewer, server: Server) -> None:
    """Open the host's link in an open page, and wait until the page is the host's."""
    said = await said_by(server.log_path.parent, "host-link", **server.environment)
    found = re.search(r"#host=\S+", said)
    assert found, f"`wax host-link` prints no link: {said!r}"
    await viewer.page.goto(f"{server.url}/{found.group()}")
    await viewer.page.get_by_role("button", name="Host", exact=True).wait_for()


@asynccontextmanager
async def replayed(folder: Path) -> AsyncIterator[str]:
    """Run `wax replay` inside the block; gives the URL of its page."""
    port = free_port()
    process = await asyncio.create_subprocess_exec(
        *(str(COMMAND), "replay", str(folder), "--port", str(port)), stdout=asyncio.subprocess.PIPE
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
        await kill(process)
