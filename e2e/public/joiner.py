"""Joins in a process of its own, so that its work disturbs no measuring client.

``python -m e2e.public.joiner URL``: for each line that it reads, ``host`` or ``guest``, it joins,
leaves, and writes how long it took until everything was open, in seconds, or why it did not.
"""

from __future__ import annotations

import asyncio
import json
import sys
import time
from typing import Final

import aiohttp

from e2e.public.strangers import ELSEWHERE
from wax.client import Client
from wax.errors import SignallingError

_NAME, _, _VALUE = ELSEWHERE.decode().partition(": ")
_HEADERS: Final = {"host": {}, "guest": {_NAME: _VALUE}}


async def _join(url: str, who: str) -> str:
    start_s = time.monotonic()
    try:
        async with Client(url, headers=_HEADERS[who], sound=False, picture=False):
            took_s = time.monotonic() - start_s
    except (SignallingError, TimeoutError, aiohttp.ClientError) as error:
        return json.dumps({"took_s": None, "problem": f"{type(error).__name__}: {error}"[:300]})
    return json.dumps({"took_s": took_s})


async def _serve(url: str) -> None:
    print(flush=True)
    while line := await asyncio.to_thread(sys.stdin.readline):
        print(await _join(url, line.strip()), flush=True)


if __name__ == "__main__":
    asyncio.run(_serve(sys.argv[1]))
