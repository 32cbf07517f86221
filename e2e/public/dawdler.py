"""Connections that take their time: ``python -m e2e.public.dawdler PORT NUMBER ADDRESSES``.

A quarter each says nothing, half a header, a header by drips, or a body by drips. Writes an empty
line when all are connected. At the end it writes as JSON, for each kind, how long it was from the
first byte of the unfinished header or body (from the connection, where there is none) until it was
closed, in seconds; None where it was not within 20 s.
"""

from __future__ import annotations

import asyncio
import json
import sys
import time
from contextlib import suppress
from typing import Any, Final

from e2e.public.strangers import OwnTime, address

_GIVE_UP_S: Final = 20.0
_DRIP_S: Final = 1.0
_HEADER: Final = b"POST /api/offer HTTP/1.1\r\nHost: 127.0.0.1:%d\r\n"
_BODY: Final = b"Content-Length: 4000\r\n\r\n"
KINDS: Final = ("silent", "half header", "drip", "slow body")


class _Dawdler:
    """One connection."""

    def __init__(self, kind: str) -> None:
        self.kind = kind
        self.lasted_s: float | None = None

    async def connect(self, port: int, source: str) -> None:
        self._reader, self._writer = await asyncio.open_connection(
            "127.0.0.1", port, local_addr=(source, 0)
        )
        self._began_s = time.monotonic()
        header = _HEADER % port
        if self.kind == "half header":
            self._writer.write(header)
        elif self.kind == "drip":
            self._writer.write(header + b"X-Never: ")
        elif self.kind == "slow body":
            self._writer.write(header + _BODY)

    async def dawdle(self) -> None:
        dripping = asyncio.create_task(self._drip())
        try:
            async with asyncio.timeout(_GIVE_UP_S):
                with suppress(ConnectionError):
                    await self._reader.read()
                self.lasted_s = time.monotonic() - self._began_s
        except TimeoutError:
            pass
        finally:
            dripping.cancel()
            self._writer.transport.abort()

    async def _drip(self) -> None:
        while self.kind in ("drip", "slow body"):
            await asyncio.sleep(_DRIP_S)
            self._writer.write(b"x")


async def _dawdle(port: int, number: int, addresses: int) -> dict[str, Any]:
    all_of_them = [_Dawdler(KINDS[n % len(KINDS)]) for n in range(number)]
    own, tasks = OwnTime(), list[asyncio.Task[None]]()
    for n, one in enumerate(all_of_them):
        await one.connect(port, address(n // len(KINDS) % addresses))
        tasks.append(asyncio.create_task(one.dawdle()))
    print(flush=True)
    await asyncio.gather(*tasks)
    lasted = {kind: [one.lasted_s for one in all_of_them if one.kind == kind] for kind in KINDS}
    return {"lasted_s": lasted, "cpu_share": own.share()}


if __name__ == "__main__":
    print(json.dumps(asyncio.run(_dawdle(*map(int, sys.argv[1:4])))))
