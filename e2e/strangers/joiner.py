"""Joins in a process of its own, so that its work disturbs no measuring client.

``python -m e2e.strangers.joiner URL STATE``, with the server's state folder: for each line that it
reads, ``host`` or ``guest``, it joins, leaves, and writes how many seconds joining took, or why it
failed.
"""

from __future__ import annotations

import asyncio
import json
import sys
import time
from pathlib import Path

import aiohttp

from wax.client import Client
from wax.client.host import become_host
from wax.errors import SignallingError


async def _join(url: str, cookies: aiohttp.CookieJar | None) -> str:
    start_s = time.monotonic()
    try:
        async with Client(url, cookies=cookies, sound=False, picture=False):
            took_s = time.monotonic() - start_s
    except (SignallingError, TimeoutError, aiohttp.ClientError) as error:
        return json.dumps({"took_s": None, "problem": f"{type(error).__name__}: {error}"[:300]})
    return json.dumps({"took_s": took_s})


async def _serve(url: str, state: Path) -> None:
    host = aiohttp.CookieJar(unsafe=True)  # the server has no name, only an address
    async with aiohttp.ClientSession(cookie_jar=host) as http:
        await become_host(http, url, state)
    print(flush=True)
    while line := await asyncio.to_thread(sys.stdin.readline):
        print(await _join(url, host if line.strip() == "host" else None), flush=True)


if __name__ == "__main__":
    asyncio.run(_serve(sys.argv[1], Path(sys.argv[2])))
