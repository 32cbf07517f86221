"""Offers without end: ``python -m e2e.public.flooder PORT RATE_HZ SECONDS ADDRESSES``.

Each comes over a connection of its own, by another client, and is never followed up; all bytes are
made before the first is sent. Writes an empty line when it begins, and at its end as JSON how many
were sent, what they were answered, and the share of a core that this took.
"""

from __future__ import annotations

import asyncio
import json
import sys
import time
import uuid
from collections import Counter
from contextlib import suppress
from itertools import cycle
from typing import Any, Final

from e2e.public.strangers import OwnTime, address
from wax.client import Client
from wax.client.sdp import as_browser

_TICK_S: Final = 0.02
_ANSWER_S: Final = 10.0


async def _requests(port: int, number: int) -> list[bytes]:
    """Make offers that differ in their clients' identities."""
    client = Client(f"http://127.0.0.1:{port}")
    await client.peer.setLocalDescription(await client.peer.createOffer())
    sdp = as_browser(client.peer.localDescription.sdp)
    await client.close()
    mark = str(uuid.uuid4())
    body = json.dumps({"sdp": sdp, "client": mark}).encode()
    head = (
        b"POST /api/offer HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nContent-Type: application/json\r\n"
        b"Content-Length: %d\r\nConnection: close\r\n\r\n" % (port, len(body))
    )
    before, after = (head + body).split(mark.encode())
    return [before + str(uuid.uuid4()).encode() + after for _ in range(number)]


async def _flood(port: int, rate_hz: float, seconds: float, addresses: int) -> dict[str, Any]:
    requests = iter(await _requests(port, int(rate_hz * seconds)))
    sources = cycle([address(number) for number in range(addresses)])
    answers: Counter[str] = Counter()
    under_way: set[asyncio.Task[None]] = set()

    async def one(request: bytes, source: str) -> None:
        said = b""
        try:
            reader, writer = await asyncio.open_connection(
                "127.0.0.1", port, local_addr=(source, 0)
            )
            try:
                writer.write(request)
                async with asyncio.timeout(_ANSWER_S):
                    said = await reader.readline()
            finally:
                writer.transport.abort()
        except OSError:
            pass
        except TimeoutError:
            said = b"- late"
        answers[said.split(b" ")[1].decode() if b" " in said else "closed"] += 1

    print(flush=True)
    own, start_s, sent = OwnTime(), time.monotonic(), 0
    while (passed_s := time.monotonic() - start_s) < seconds:
        while sent < passed_s * rate_hz and (request := next(requests, None)) is not None:
            task = asyncio.create_task(one(request, next(sources)))
            under_way.add(task)
            task.add_done_callback(under_way.discard)
            sent += 1
        await asyncio.sleep(_TICK_S)
    share, took_s = own.share(), time.monotonic() - start_s
    if under_way:
        with suppress(TimeoutError):
            async with asyncio.timeout(_ANSWER_S):
                await asyncio.gather(*under_way)
    return {"sent": sent, "sent_hz": sent / took_s, "answers": dict(answers), "cpu_share": share}


if __name__ == "__main__":
    _port, _rate_hz, _seconds, _addresses = sys.argv[1:5]
    print(
        json.dumps(
            asyncio.run(_flood(int(_port), float(_rate_hz), float(_seconds), int(_addresses)))
        )
    )
