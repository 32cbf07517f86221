"""The sockets where connections come in: accepts a few in each pass of the event loop."""

from __future__ import annotations

import asyncio
import errno
import socket
import time
from typing import TYPE_CHECKING, Final

import structlog

from wax.edge.binding import listen

if TYPE_CHECKING:
    from collections.abc import Callable

_LOG = structlog.get_logger(__name__)

_ACCEPT_IN_A_PASS: Final = 16
_ACCEPT_S: Final = 0.001
"""By whichever comes first; where they wait in line, whoever is known passes the others."""
_RECEIVE_BYTES: Final = 32_768
"""What one connection can bring to one pass; the largest request is a body of 64 KiB."""
_SEND_BYTES: Final = 131_072
"""What the kernel holds for one that does not read: as much as a second of a thin link carries."""
_NO_MORE: Final = frozenset({errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM})
_PAUSE_S: Final = 1.0
_FULL_EVERY_S: Final = 60.0


class Listening:
    """Listens on all addresses of a host; raises `OSError`. `accept` gets each new connection."""

    def __init__(self, host: str, port: int, accept: Callable[[socket.socket, str], None]) -> None:
        self._loop = asyncio.get_running_loop()
        self._accept = accept
        self._told_s = float("-inf")
        self._sockets = listen(host, port)
        for listening in self._sockets:
            # What it accepts has the same.
            listening.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _RECEIVE_BYTES)
            listening.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BYTES)
            self._loop.add_reader(listening, self._come, listening)

    @property
    def port(self) -> int:
        return int(self._sockets[0].getsockname()[1])

    def close(self) -> None:
        """Stop listening; may be called again."""
        for one in self._sockets:
            self._loop.remove_reader(one)
            one.close()
        self._sockets = []

    def _come(self, listening: socket.socket) -> None:
        until_s = time.thread_time() + _ACCEPT_S
        for _ in range(_ACCEPT_IN_A_PASS):
            try:
                connection, peer = listening.accept()
            except (BlockingIOError, InterruptedError, ConnectionAbortedError):
                return
            except OSError as error:
                if error.errno not in _NO_MORE:
                    raise
                self._pause(listening, error)
                return
            connection.setblocking(False)
            self._accept(connection, peer[0])
            if time.thread_time() >= until_s:
                return

    def _pause(self, listening: socket.socket, error: OSError) -> None:
        """Wait for descriptors: the socket stays readable, and would keep the loop busy."""
        now_s = self._loop.time()
        if now_s - self._told_s >= _FULL_EVERY_S:
            self._told_s = now_s
            _LOG.warning(
                "no further connection can be accepted: raise the limit of open files",
                problem=error.strerror,
            )
        self._loop.remove_reader(listening)
        self._loop.call_later(_PAUSE_S, self._resume, listening)

    def _resume(self, listening: socket.socket) -> None:
        if listening in self._sockets:
            self._loop.add_reader(listening, self._come, listening)
