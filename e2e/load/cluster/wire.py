"""How many bytes TCP connections cost the wire, told by Linux (``TCP_INFO``, tcp(7))."""

from __future__ import annotations

import asyncio
import socket
import struct
from contextlib import asynccontextmanager, suppress
from typing import TYPE_CHECKING, Any, Final

from e2e.harness.server import free_port

if TYPE_CHECKING:
    from asyncio import StreamReader, StreamWriter
    from collections.abc import AsyncIterator

_ADDRESS: Final = "127.0.0.1"
_SEGMENT_BYTES: Final = 14 + 20 + 32
"""Headers of Ethernet, IPv4, and TCP with its timestamps."""
_CLOSING: Final = 2
"""Segments that follow the last look: our FIN, and its acknowledgement."""
_MAX_SEGMENT_BYTES: Final = 1460
"""Ethernet's; the loopback interface would take 64 KiB at once."""
_COUNTS: Final = struct.Struct("=QQII")
_AT: Final = 120
"""Where `tcpi_bytes_acked`, `tcpi_bytes_received`, `tcpi_segs_out`, `tcpi_segs_in` are."""
_READ: Final = 65_536


class Wire:
    """Sums up connections, those that have ended too; both directions, all headers."""

    def __init__(self) -> None:
        self._open: set[socket.socket] = set()
        self._ended = 0

    def bytes(self) -> int:
        """Return how many there have been so far."""
        return self._ended + sum(map(_cost, self._open))

    def connecting(self, address: tuple[Any, ...]) -> socket.socket:
        """Make a socket to connect by that is counted, for aiohttp's connector."""
        family, kind, protocol, _, _ = address
        made = _Counted(self, family, kind, protocol)
        made.setsockopt(socket.IPPROTO_TCP, socket.TCP_MAXSEG, _MAX_SEGMENT_BYTES)
        self.begin(made)
        return made

    def begin(self, one: socket.socket) -> None:
        """Count this one from its first byte on."""
        self._open.add(one)

    def end(self, one: socket.socket) -> None:
        """Count it for the last time; it is about to be closed."""
        if one in self._open:
            self._open.remove(one)
            with suppress(OSError):  # it may never have been connected
                self._ended += _cost(one) + _CLOSING * _SEGMENT_BYTES


class _Counted(socket.socket):
    def __init__(self, wire: Wire, family: int, kind: int, protocol: int) -> None:
        super().__init__(family, kind, protocol)
        self._wire = wire

    def close(self) -> None:
        self._wire.end(self)
        super().close()


def _cost(one: socket.socket) -> int:
    info = one.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, _AT + _COUNTS.size)
    acknowledged, received, out, came = _COUNTS.unpack_from(info, _AT)
    return int(acknowledged + received + _SEGMENT_BYTES * (out + came))


@asynccontextmanager
async def counted(wire: Wire, port: int) -> AsyncIterator[int]:
    """Pass on to `port` of this machine what comes to the port that the block gets."""

    async def serve(reader: StreamReader, writer: StreamWriter) -> None:
        accepted = writer.get_extra_info("socket")
        wire.begin(accepted)
        onwards, back = await asyncio.open_connection(_ADDRESS, port)
        try:
            await asyncio.gather(_pipe(reader, back), _pipe(onwards, writer))
        finally:
            wire.end(accepted)
            writer.close()
            back.close()

    listening = socket.socket()
    listening.setsockopt(socket.IPPROTO_TCP, socket.TCP_MAXSEG, _MAX_SEGMENT_BYTES)
    listening.bind((_ADDRESS, free_port()))
    server = await asyncio.start_server(serve, sock=listening)
    try:
        yield listening.getsockname()[1]
    finally:
        server.close()


async def _pipe(reader: StreamReader, writer: StreamWriter) -> None:
    with suppress(ConnectionError):
        while data := await reader.read(_READ):
            writer.write(data)
            await writer.drain()
        writer.write_eof()
