"""The link that makes a browser the host's, got as a host gets it."""

from __future__ import annotations

import asyncio
import os
import re
from typing import TYPE_CHECKING

from e2e.harness.server import COMMAND

if TYPE_CHECKING:
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer


async def host_link(server: Server) -> str:
    """Return what of the link comes after the page's address."""
    process = await asyncio.create_subprocess_exec(
        *(str(COMMAND), "host-link", "--config", str(server.log_path.with_name("wax.toml"))),
        stdout=asyncio.subprocess.PIPE,
        env=os.environ | server.environment,
    )
    said, _ = await process.communicate()
    found = re.search(r"#host=\S+", said.decode())
    assert found, f"`wax host-link` prints no link: {said!r}"
    return found.group()


async def become_host(viewer: Viewer, server: Server) -> None:
    """Open the host's link in a page that is open already, and wait until it is the host's."""
    await viewer.page.goto(f"{server.url}/{await host_link(server)}")
    await viewer.page.get_by_role("button", name="Host", exact=True).wait_for()
