"""A TCP server at one end, reached from outside by a Unix socket, which ignores namespaces.

``python -m e2e.delay.relay SOCKET HOST PORT`` listens on SOCKET, then writes an empty line, and
forwards each connection to HOST:PORT. It ends with its standard input, so it outlives nobody who
started it.
"""

from __future__ import annotations

import asyncio
import sys
import tempfile
from contextlib import asynccontextmanager, suppress
from typing import TYPE_CHECKING, Final

import aiohttp

from e2e.harness.child import child

if TYPE_CHECKING:
    from asyncio import StreamReader, StreamWriter
    from collections.abc import AsyncIterator

    from e2e.link import End

_END_WITHIN_S: Final = 5.0
_PIECE_BYTES: Final = 65_536


@asynccontextmanager
async def http_through(end: End, host: str, port: int) -> AsyncIterator[aiohttp.ClientSession]:
    """Yield a client whose every connection goes to `host` and `port` as seen from `end`.

    Nobody need listen there yet. Raises `MeasureError` if the relay does not start.
    """
    # In a folder of its own, not the caller's, since a socket's path has at most 107 characters.
    with tempfile.TemporaryDirectory(prefix="lab-") as folder:
        path = f"{folder}/relay"
        relay = child(
            "e2e.delay.relay", path, host, port, leaves_s=_END_WITHIN_S, through=end.command
        )
        async with relay as running:
            await running.line()  # it listens
            async with aiohttp.ClientSession(
                connector=aiohttp.UnixConnector(path),
                cookie_jar=aiohttp.CookieJar(unsafe=True),  # the servers are addresses
            ) as http:
                yield http


async def _relay(path: str, host: str, port: int) -> None:
    kept: list[asyncio.Task[None]] = []

    def accept(reader: StreamReader, writer: StreamWriter) -> None:
        kept.append(asyncio.create_task(_hand_on(reader, writer, host, port)))

    server = await asyncio.start_unix_server(accept, path)
    print(flush=True)
    await asyncio.to_thread(sys.stdin.read)
    server.close()


async def _hand_on(reader: StreamReader, writer: StreamWriter, host: str, port: int) -> None:
    try:
        from_there, to_there = await asyncio.open_connection(host, port)
    except OSError:
        writer.close()  # looks like a refused connection: the client tries again
        return
    await asyncio.gather(_pump(reader, to_there), _pump(from_there, writer))


async def _pump(source: StreamReader, sink: StreamWriter) -> None:
    """Forward one direction; its end is the end of both."""
    with suppress(OSError):
        while piece := await source.read(_PIECE_BYTES):
            sink.write(piece)
            await sink.drain()
    sink.close()


if __name__ == "__main__":
    asyncio.run(_relay(sys.argv[1], sys.argv[2], int(sys.argv[3])))
