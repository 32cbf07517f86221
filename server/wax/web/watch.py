"""The timeouts of a connection: for sending a request, reading the answer, and idling.

aiohttp has no timeout for headers and bodies, so a connection that sends nothing, or a byte now and
then, would stay open for ever.
"""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Final, Literal

if sys.platform != "win32":
    import fcntl
    import termios

if TYPE_CHECKING:
    import asyncio

    from aiohttp import web

    from wax.web.connection_limits import TrackedConnection
    from wax.web.http_limits import HttpLimits

    State = Literal["idle", "reading", "answering"]

READ_S: Final = 9.0
"""From the first byte of a header or body to its last, and from connecting to the header's end."""
IDLE_S: Final = 30.0
"""How long an answered connection is kept for the next request."""
ANSWER_S: Final = 120.0
"""How long an answer may take: the page takes most of a minute over a modem."""
STALL_S: Final = 15.0
"""How long an answer may stall: TCP has sent a lost segment for the fourth time by then."""
_LASTS_S: Final[dict[State, float]] = {"idle": IDLE_S, "reading": READ_S, "answering": ANSWER_S}


class ConnectionWatch:
    """Ends a connection that exceeds the timeout of its state."""

    def __init__(
        self,
        limits: HttpLimits,
        loop: asyncio.AbstractEventLoop,
        transport: asyncio.Transport,
        tracked: TrackedConnection,
    ) -> None:
        self._limits = limits
        self._loop = loop
        self._transport = transport
        self.tracked = tracked
        self.is_queued = False
        """Whether a complete header waits for its sender's turn: the client is not slow."""
        self._state: State = "reading"
        self._request: web.BaseRequest | None = None
        self._moves = 0
        self._seen = (0, 0)
        self._until_s = loop.time() + _LASTS_S["reading"]
        self._timer = loop.call_at(self._until_s, self._on_timeout)
        tracked.close = transport.abort

    def note_data(self) -> None:
        if self._state == "idle":
            self._set_state("reading")

    def header_parsed(self, request: web.BaseRequest) -> None:
        self._request = request
        self._set_state("answering" if request.content.is_eof() else "reading")

    def answered(self, *, more: bool) -> None:
        """Wait for the next request, which has begun to arrive if there is `more`."""
        self._request = None
        self._set_state("reading" if more else "idle")

    def note_progress(self) -> None:
        """Note that the client has read more."""
        self._moves += 1

    def _is_stalled(self) -> bool:
        """Whether the client has read nothing of an answer since the last call."""
        unread = self._transport.get_write_buffer_size()
        try:
            line = self._transport.get_extra_info("socket")
            found = fcntl.ioctl(line.fileno(), termios.TIOCOUTQ, bytes(4))
            unread += int.from_bytes(found, sys.byteorder)
        except OSError:  # only Linux tells; elsewhere, only `ANSWER_S` limits an answer
            return False
        before, self._seen = self._seen, (unread, self._moves)
        return unread > 0 and self._seen == before

    def end(self) -> None:
        self._timer.cancel()
        self._request = None
        self._limits.connections.leave(self.tracked)

    def _set_state(self, state: State) -> None:
        connections = self._limits.connections
        now_s = self._loop.time()
        if state == "idle":
            connections.mark_idle(self.tracked)
        elif state == "answering":
            connections.mark_answering(self.tracked)
        elif self._state != "reading":
            connections.mark_reading(self.tracked, now_s)
        self._state = state
        self._until_s = now_s + _LASTS_S[state]
        self._set_timer()

    def _set_timer(self) -> None:
        self._timer.cancel()
        until_s = self._until_s
        if self._state == "answering":
            until_s = min(until_s, self._loop.time() + STALL_S)
        self._timer = self._loop.call_at(until_s, self._on_timeout)

    def _on_timeout(self) -> None:
        now_s = self._loop.time()
        if self._state == "reading" and self._request and self._request.content.is_eof():
            self._set_state("answering")
            return
        if self._state == "reading" and self.is_queued:
            self._set_state("reading")
            return
        if self._state == "answering" and now_s < self._until_s and not self._is_stalled():
            self._set_timer()
            return
        if self._state != "idle":
            self._limits.count_cut(f"too slow while {self._state}")
        # Not `close`, which waits until everything is sent: this client may never read it.
        self._limits.end_soon(self._transport.abort)
