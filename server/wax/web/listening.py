"""The listening sockets: accept a few connections in each pass of the event loop."""

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
"""The first limit reached counts; in the queue that follows, known senders pass others."""
_RECEIVE_BYTES: Final = 32_768
"""The most that a connection can bring to one pass; the largest request is a body of 64 KiB."""
_SEND_BYTES: Final = 131_072
"""What the kernel buffers for a client that does not read: about a second of a thin link."""
_NO_MORE: Final = frozenset({errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM})
_PAUSE_S: Final = 1.0
_FULL_EVERY_S: Final = 60.0


class Listening:
    """Listens on all addresses of a host; raises `OSError`. `accept` gets each new connection."""

    def __init__(self, host: str, port: int, accept: Callable[[socket.socket, str], None]) -> None:
        self._loop = asyncio.get_running_loop()
        self._accept = accept
        self._warned_s = float("-inf")
        self._sockets = listen(host, port)
        for listening in self._sockets:
            # Accepted connections inherit both.
            listening.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _RECEIVE_BYTES)
            listening.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BYTES)
            self._loop.add_reader(listening, self._accept_some, listening)

    @property
    def port(self) -> int:
        return int(self._sockets[0].getsockname()[1])

    def close(self) -> None:
        """Stop listening; may be called again."""
        for one in self._sockets:
            self._loop.remove_reader(one)
            one.close()
        self._sockets = []

    def _accept_some(self, listening: socket.socket) -> None:
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
        """Wait for free descriptors: the socket stays readable, and would keep the loop busy."""
        now_s = self._loop.time()
        if now_s - self._warned_s >= _FULL_EVERY_S:
            self._warned_s = now_s
            _LOG.warning(
                "no further connection can be accepted: raise the limit of open files",
                problem=error.strerror,
            )
        self._loop.remove_reader(listening)
        self._loop.call_later(_PAUSE_S, self._resume, listening)

    def _resume(self, listening: socket.socket) -> None:
        if listening in self._sockets:
            self._loop.add_reader(listening, self._accept_some, listening)
