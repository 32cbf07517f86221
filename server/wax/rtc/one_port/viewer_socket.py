"""One viewer's own receive queue on the shared port.

A UDP socket on the same port that is connected to a viewer's address gets exactly the datagrams
from there, and the shared socket gets all others (Linux, since 5.4). So a flood fills only its
sender's queue, the kernel drops the overflow at no cost, and the queue is not even read while that
viewer is over budget.
"""

from __future__ import annotations

import asyncio
import socket
import sys
from contextlib import suppress
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.rtc.one_port.lite_agent import Path

CAN_CONNECT: Final = sys.platform == "linux"
_AT_ONCE: Final = 16
"""Datagrams read in one pass of the event loop."""
_LONGEST_BYTES: Final = 65_536


class ViewerSocket:
    """Reads the datagrams of one path; raises `OSError` if the system has no socket for it.

    `on_datagram` gets each datagram with its sender, and returns whether to read on; if not,
    `resume` does.
    """

    def __init__(
        self, path: Path, bound: socket.socket, on_datagram: Callable[[bytes, str, int], bool]
    ) -> None:
        self.path = path
        self._on_datagram = on_datagram
        self._loop = asyncio.get_running_loop()
        self._is_reading = False
        bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        self._socket = socket.socket(bound.family, socket.SOCK_DGRAM)
        try:
            self._socket.setblocking(False)
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
            self._socket.bind(bound.getsockname())
            self._socket.connect((path.host, path.port))
        except OSError:
            self._socket.close()
            raise
        self.resume()

    def resume(self) -> None:
        """Resume reading; safe to repeat, and after `close`."""
        if not self._is_reading and self._socket.fileno() >= 0:
            self._is_reading = True
            self._loop.add_reader(self._socket, self._read)

    def close(self) -> None:
        """Leave this path's datagrams to the shared socket; safe to call twice."""
        self._pause()
        self._socket.close()

    def _pause(self) -> None:
        if self._is_reading:
            self._is_reading = False
            self._loop.remove_reader(self._socket)

    def _read(self) -> None:
        # OSError: nothing left to read, or an ICMP message, which anybody can forge.
        with suppress(OSError):
            for _ in range(_AT_ONCE):
                # Between `bind` and `connect` the kernel may have queued datagrams from elsewhere.
                data, address = self._socket.recvfrom(_LONGEST_BYTES)
                if not self._on_datagram(data, address[0].partition("%")[0], address[1]):
                    self._pause()
                    return
