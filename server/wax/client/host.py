"""Makes a program the host of a server on this machine, as `wax host-link` does for a person."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from wax.access import host_link
from wax.errors import StateError

if TYPE_CHECKING:
    from pathlib import Path

    import aiohttp


async def become_host(http: aiohttp.ClientSession, url: str, state: Path) -> None:
    """Give the session a host's cookies; `state` is the server's state folder.

    Raises `StateError` or `aiohttp.ClientError`.
    """
    link, *_ = await asyncio.to_thread(host_link.request_links, state)
    secret = urlsplit(link).fragment.removeprefix("host=")
    async with http.post(f"{url}/api/host", json={"secret": secret}) as response:
        if not response.ok:
            raise StateError(f"{url} refuses its own host link: {response.status}")
