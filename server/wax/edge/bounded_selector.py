"""Which sockets the event loop serves in one pass: of the connections that came in, only a few.

asyncio serves every socket that is ready before it looks at its timers. Hundreds of connections
that end at once would take a tenth of a second, and with it the robot's next set-point.
"""

from __future__ import annotations

import asyncio
import heapq
import selectors
import socket
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from _typeshed import FileDescriptorLike

CONNECTIONS_IN_A_PASS: Final = 16
"""Each costs a third of a millisecond at most until it has ended: here and in the next passes."""


class BoundedSelector(selectors.DefaultSelector):
    """The platform's selector, which leaves connections beyond the first few for the next pass.

    Whoever has just come, or may just be read again, is first, and then whoever has waited longest:
    a Stop does not wait behind those that only end. Sockets of our own are always served.
    """

    def __init__(self) -> None:
        super().__init__()
        self._listened_on: set[int] = set()
        self._served_at: dict[int, int] = {}
        self._passes = 0

    def register(
        self, fileobj: FileDescriptorLike, events: int, data: Any = None
    ) -> selectors.SelectorKey:
        key = super().register(fileobj, events, data)
        if self._has_come_in(key.fd):
            self._served_at[key.fd] = 0
        return key

    def unregister(self, fileobj: FileDescriptorLike) -> selectors.SelectorKey:
        key = super().unregister(fileobj)
        self._served_at.pop(key.fd, None)
        return key

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        ready = super().select(timeout)
        if len(ready) <= CONNECTIONS_IN_A_PASS:
            return ready
        served_at = self._served_at
        theirs = [one for one in ready if one[0].fd in served_at]
        first = heapq.nsmallest(CONNECTIONS_IN_A_PASS, theirs, key=lambda one: served_at[one[0].fd])
        self._passes += 1
        for key, _ in first:
            served_at[key.fd] = self._passes
        return [one for one in ready if one[0].fd not in served_at] + first

    def _has_come_in(self, fd: int) -> bool:
        """Return whether a socket is one end of a connection to a port that is listened on."""
        try:
            found = socket.socket(fileno=fd)
        except OSError:  # no socket
            return False
        try:
            if found.type != socket.SOCK_STREAM or found.family == socket.AF_UNIX:
                return False
            port = found.getsockname()[1]
            if found.getsockopt(socket.SOL_SOCKET, socket.SO_ACCEPTCONN):
                self._listened_on.add(port)
                return False
            return port in self._listened_on
        finally:
            found.detach()


def bounded_loop() -> asyncio.AbstractEventLoop:
    return asyncio.SelectorEventLoop(BoundedSelector())
