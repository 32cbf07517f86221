"""One HTTP connection: aiohttp's, which gives its client only so much time.

aiohttp has no time limit for headers and bodies, so a connection that says nothing, or a byte now
and then, would stay open for ever.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal, cast

from aiohttp import web

from wax.web.security_headers import always

if TYPE_CHECKING:
    import asyncio

    from wax.web.connection_limits import Place
    from wax.web.entrance import Entrance

    State = Literal["idle", "reading", "answering"]

READ_S: Final = 9.0
"""From the first byte of a header, or of a body, to its last; also from nothing to the header."""
IDLE_S: Final = 30.0
"""How long an answered connection is kept for the next request."""
ANSWER_S: Final = 120.0
"""How long an answer may take: the page takes most of a minute over a modem."""
_LASTS_S: Final[dict[State, float]] = {"idle": IDLE_S, "reading": READ_S, "answering": ANSWER_S}

_LINGER_S: Final = 2.0
"""How long the rest of a body is thrown away, so that the client reads why it was refused."""
_HEADER_END: Final = b"\r\n\r\n"
_MAX_HEADERS: Final = 64


class Watch:
    """Ends a connection that takes too long over what it is doing."""

    def __init__(
        self,
        entrance: Entrance,
        loop: asyncio.AbstractEventLoop,
        transport: asyncio.Transport,
        place: Place,
    ) -> None:
        self._entrance = entrance
        self._loop = loop
        self._transport = transport
        self._place = place
        self._state: State = "reading"
        self._request: web.BaseRequest | None = None
        self._last = b""
        self._begun_s = loop.time()
        self._timer = loop.call_at(self._begun_s + _LASTS_S["reading"], self._time_is_over)
        place.close = transport.abort

    def received(self, data: bytes) -> None:
        self._last = (self._last + data[-len(_HEADER_END) :])[-len(_HEADER_END) :]
        if self._state == "idle":
            self._begin("reading")

    def header_came(self, request: web.BaseRequest) -> None:
        self._request = request
        self._begin("answering" if request.content.is_eof() else "reading")

    def answered(self) -> None:
        self._request = None
        # Behind the end of a request there may already be the beginning of the next one.
        self._begin("idle" if self._last == _HEADER_END else "reading")

    def end(self) -> None:
        self._timer.cancel()
        self._request = None
        self._entrance.limits.leave(self._place)

    def _begin(self, state: State) -> None:
        limits = self._entrance.limits
        if state == "idle":
            limits.idles(self._place)
        elif state == "reading":
            limits.reads(self._place)
        else:
            limits.answers(self._place)
        self._state = state
        self._begun_s = self._loop.time()
        self._timer.cancel()
        self._timer = self._loop.call_at(self._begun_s + _LASTS_S[state], self._time_is_over)

    def _time_is_over(self) -> None:
        if self._state == "reading" and self._request and self._request.content.is_eof():
            self._begin("answering")
            return
        if self._state != "idle":
            self._entrance.cut(f"too slow while {self._state}")
        # Not `close`, which waits until everything is sent, and this client need not read.
        self._transport.abort()


class Connection(web.RequestHandler):
    """Made by the `Entrance` for each connection; `place` if it has one already."""

    __slots__ = ("_entrance", "_loop_of_watch", "_place", "_watch")

    def __init__(
        self,
        entrance: Entrance,
        server: web.Server,
        loop: asyncio.AbstractEventLoop,
        place: Place | None = None,
    ) -> None:
        super().__init__(
            server,
            loop=loop,
            keepalive_timeout=IDLE_S,
            lingering_time=_LINGER_S,
            access_log=None,  # type: ignore[arg-type]  # None means no log, as in AppRunner
            max_headers=_MAX_HEADERS,
            auto_decompress=False,
        )
        self._entrance = entrance
        self._loop_of_watch = loop
        self._place = place
        self._watch: Watch | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Begin to read, if there is a place; else close the connection at once."""
        line = cast("asyncio.Transport", transport)
        place = self._place or self._entrance.enter(line)
        if place is None:
            line.abort()
            return
        self._watch = Watch(self._entrance, self._loop_of_watch, line, place)
        super().connection_made(transport)

    def data_received(self, data: bytes) -> None:
        """Pass data on; aiohttp also calls this, without data, to go on with what it has."""
        if data and self._watch is not None:
            self._watch.received(data)
        super().data_received(data)

    def header_came(self, request: web.BaseRequest) -> None:
        """Go on to the body; called by the first middleware."""
        if self._watch is not None:
            self._watch.header_came(request)

    async def finish_response(
        self, request: web.BaseRequest, resp: web.StreamResponse, start_time: float | None
    ) -> tuple[web.StreamResponse, bool]:
        """Send the answer; then wait for the next request."""
        try:
            return await super().finish_response(request, resp, start_time)
        finally:
            if self._watch is not None:
                self._watch.answered()

    def handle_error(
        self,
        request: web.BaseRequest,
        status: int = 500,
        exc: BaseException | None = None,
        message: str | None = None,
    ) -> web.StreamResponse:
        """Answer what is no HTTP: briefly, and with a line in the log now and then."""
        if status >= 500:
            return super().handle_error(request, status, exc, message)
        self._entrance.log.info("bad request", why=type(exc).__name__, sender=request.remote)
        answer = web.json_response(
            {"error": "That is no HTTP request that this server understands."},
            status=status,
            headers=always(),
        )
        answer.force_close()
        return answer

    def connection_lost(self, exc: BaseException | None) -> None:
        """Give the place away."""
        if self._watch is not None:
            self._watch.end()
            self._watch = None
        super().connection_lost(exc)
