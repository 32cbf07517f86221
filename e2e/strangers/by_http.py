"""Attacks by HTTP, from any number of loopback addresses."""

from __future__ import annotations

import asyncio
import re
import socket
import time
import uuid
from collections import deque
from contextlib import suppress
from functools import partial
from itertools import cycle
from struct import pack, unpack
from typing import TYPE_CHECKING, Final

from e2e.strangers import wire
from e2e.strangers.ground import address, together
from e2e.strangers.intruder import Intruder, ask

if TYPE_CHECKING:
    from collections import Counter
    from collections.abc import Callable, Coroutine, Sequence

    from e2e.strangers.ground import Ground

PAGE: Final = wire.http("/", ("Accept-Encoding", "gzip"))
HEALTH: Final = wire.http("/healthz")
COOKIES: Final = wire.http("/healthz", *[("Cookie", "a a;" * 2000)] * 8)
"""64 kB in lines as long as HTTP servers accept. No name there is valid, so a lenient parser tries
all its rules on each."""
CRUMBS: Final = (
    b"POST /api/enter HTTP/1.1\r\nHost: 127.0.0.1\r\nTransfer-Encoding: chunked\r\n\r\n"
    + b"1\r\nx\r\n" * 10_000
)
"""A body without a last chunk, in chunks of a byte."""
KEYS: Final = wire.post("/api/host", b"{" + b",".join(b'"%x":1' % n for n in range(7000)) + b"}")
"""As many keys as a body has room for, all unknown."""
_UNFINISHED: Final = wire.post("/api/offer", b"x" * 65_536)[:-1]
_PIPELINED: Final = 20
_WRITTEN_BYTES: Final = 262_144
_ANSWERED_BYTES: Final = 65_536
_AGAIN_S: Final = 0.5
"""How long to wait before retrying a closed or refused connection."""
_DRIP_S: Final = 1.0
_HEADER: Final = b"POST /api/offer HTTP/1.1\r\nHost: 127.0.0.1\r\n"
_SLOW: Final = (
    ("silent", b"", False),
    ("half header", _HEADER, False),
    ("drip", _HEADER + b"X-Never: ", True),
    ("slow body", _HEADER + b"Content-Length: 4000\r\n\r\n", True),
)


async def pipelined(
    ground: Ground, connections: int, addresses: int, rate_hz: float, request: bytes
) -> None:
    """Pipeline requests on connections that stay open, and read each answer."""
    senders = [(address(number % addresses), request) for number in range(connections)]
    await _keep_asking(ground, senders, rate_hz)


async def releases(ground: Ground, connections: int, rate_hz: float) -> None:
    """Let each viewer, by so many connections, ask to release a Stop, which none of them may do."""
    senders: list[tuple[str, bytes]] = []
    for intruder in ground.intruders:
        request = wire.post("/api/release", b'{"stop": 1}', intruder.cookie)
        senders += [(intruder.source, request)] * connections
    await _keep_asking(ground, senders, rate_hz)


async def _keep_asking(
    ground: Ground, senders: Sequence[tuple[str, bytes]], rate_hz: float
) -> None:
    async def one(source: str, request: bytes) -> None:
        requests = max(1, min(_PIPELINED, _WRITTEN_BYTES // len(request)))
        each_s = requests * len(senders) / rate_hz
        reader, writer = await _connected(ground.port, source)
        reading = asyncio.create_task(_drain(reader, ground.account))
        try:
            async for _ in ground.ticks(each_s):
                if reading.done():
                    ground.account["closed"] += 1
                    break
                if writer.transport.get_write_buffer_size() == 0:
                    writer.write(request * requests)
                    ground.account["requests"] += requests
        finally:
            reading.cancel()
            writer.transport.abort()

    await together(_again(ground, partial(one, *sender)) for sender in senders)


async def unfinished(ground: Ground, connections: int, addresses: int) -> None:
    """Send all but the last byte of the longest body, and wait until the connection is closed."""

    async def one(source: str) -> None:
        reader, writer = await _connected(ground.port, source)
        try:
            writer.write(_UNFINISHED)
            ground.account["connected"] += 1
            left_s = ground.until_s - time.monotonic()
            await asyncio.wait_for(_drain(reader, ground.account), max(left_s, 0.0))
            ground.account["closed"] += 1
        finally:
            writer.transport.abort()

    sources = [address(number % addresses) for number in range(connections)]
    await together(_again(ground, partial(one, source)) for source in sources)


async def _again(ground: Ground, one: Callable[[], Coroutine[None, None, None]]) -> None:
    async for _ in ground.ticks(_AGAIN_S):
        with suppress(OSError, TimeoutError):
            await one()


async def never_read(ground: Ground, connections: int, addresses: int) -> None:
    """Request the largest file again and again, and read nothing."""
    path = await _largest_asset(ground.port)
    request = wire.http(path) * _PIPELINED

    async def one(number: int) -> None:
        async for _ in ground.ticks(_AGAIN_S):
            try:
                made = socket.socket()
                made.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
                made.setblocking(False)
                made.bind((address(number % addresses), 0))
                with made:
                    loop = asyncio.get_running_loop()
                    await asyncio.wait_for(loop.sock_connect(made, ("127.0.0.1", ground.port)), 5)
                    ground.account["connected"] += 1
                    await asyncio.wait_for(loop.sock_sendall(made, request), 5)
                    # Until the server closes it, which a client that never reads must look up.
                    async for _ in ground.ticks(_AGAIN_S):
                        if _is_closed(made):
                            ground.account["closed"] += 1
                            break
            except (OSError, TimeoutError):
                ground.account["refused"] += 1

    await together(one(number) for number in range(connections))


def _is_closed(made: socket.socket) -> bool:
    """Whether the other end has closed it, by the kernel's TCP state (tcp(7))."""
    information = made.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, 8)
    established = 1
    return bool(unpack("8B", information)[0] != established)


async def _largest_asset(port: int) -> str:
    page = await ask(port, "GET", "/")
    paths = set(re.findall(r'/assets/[^"]+(?=")', page.body.decode("utf-8", "replace")))
    sizes = {path: len((await ask(port, "GET", path)).body) for path in sorted(paths)}
    return max(sizes, key=lambda path: sizes[path], default="/")


async def resets(ground: Ground, rate_hz: float, addresses: int) -> None:
    """Connect, and reset each connection at once (socket(7), SO_LINGER)."""
    begun: deque[socket.socket] = deque()
    sources = cycle([address(number) for number in range(addresses)])
    try:
        async for _ in ground.ticks(1 / rate_hz):
            made = socket.socket()
            begun.append(made)
            made.setblocking(False)
            made.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, pack("ii", 1, 0))
            made.bind((next(sources), 0))
            made.connect_ex(("127.0.0.1", ground.port))
            ground.account["connected"] += 1
            if len(begun) > _PIPELINED:
                begun.popleft().close()
    finally:
        for made in begun:
            made.close()


async def dawdle(ground: Ground, connections: int, addresses: int) -> None:
    """Send nothing, half a header, or a header or body in drips, until the server closes."""
    one_by_one = asyncio.Lock()  # beyond the kernel's backlog, they would stay half open for ever

    async def one(number: int) -> None:
        kind, begun, drips = _SLOW[number % len(_SLOW)]
        source = address(number // len(_SLOW) % addresses)
        async with one_by_one:
            reader, writer = await _connected(ground.port, source)
        ground.account["connected"] += 1
        since_s = time.monotonic()
        writer.write(begun)
        closed = asyncio.create_task(_drain(reader, ground.account))
        try:
            while not closed.done() and not ground.is_over:
                await asyncio.wait([closed], timeout=_DRIP_S)
                if drips:
                    writer.write(b"x")
            lasted_s = time.monotonic() - since_s
            ground.lasted_s.setdefault(kind, []).append(lasted_s if closed.done() else None)
        finally:
            closed.cancel()
            writer.transport.abort()

    await together(one(number) for number in range(connections))


async def offers(
    ground: Ground, rate_hz: float, sources: int, *, shaped: Callable[[str], str]
) -> None:
    """Send offers that no connection follows, each from a new browser, `shaped` from a real one."""
    silent = Intruder(0)
    try:
        sdp = shaped(await silent.description())
    finally:
        await silent.close()
    asking: set[asyncio.Task[None]] = set()

    async def one(source: str) -> None:
        sent = {"sdp": sdp, "client": str(uuid.uuid4())}
        answer = await ask(ground.port, "POST", "/api/offer", source=source, body=sent)
        ground.account[f"answered {answer.status}"] += 1

    addresses = cycle([address(number) for number in range(sources)])
    try:
        async for _ in ground.ticks(1 / rate_hz):
            task = asyncio.create_task(one(next(addresses)))
            asking.add(task)
            task.add_done_callback(asking.discard)
            ground.account["offers"] += 1
    finally:
        for task in asking:
            task.cancel()
        await asyncio.gather(*asking, return_exceptions=True)


async def _connected(port: int, source: str) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
    async with asyncio.timeout(10):
        return await asyncio.open_connection("127.0.0.1", port, local_addr=(source, 0))


async def _drain(reader: asyncio.StreamReader, account: Counter[str]) -> None:
    with suppress(OSError):
        while piece := await reader.read(_ANSWERED_BYTES):
            account["bytes back"] += len(piece)
