"""One HTTP connection: aiohttp's, with limits on its client's time and work.

aiohttp parses whatever arrives. So it gets one request at a time, when its sender's turn has come
(`wax.web.request_queue`), and nothing is read meanwhile.
"""

from __future__ import annotations

import asyncio
import json
import time
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, TypeVar, cast

from aiohttp import web

from wax.machine.memory import break_circle
from wax.sentence import Sentence
from wax.web import cookies
from wax.web.request_head import MAX_HEADERS, Head, Requests, read_head
from wax.web.security_headers import base_headers
from wax.web.senders import limit_key
from wax.web.timed import timed
from wax.web.watch import IDLE_S, ConnectionWatch

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine

    from aiohttp import StreamReader

    from wax.edge.budget import Payer
    from wax.web.connection_limits import TrackedConnection
    from wax.web.http_limits import HttpLimits
    from wax.web.request_queue import WaitingRequest

    _T = TypeVar("_T")

_LINGER_S: Final = 2.0
"""How long the rest of a refused body is read and dropped, so that the client reads why."""
_PIECE_S: Final = 0.00003
_REQUEST_S: Final = 0.00015
"""What the event loop spends beyond what is measured: on each piece received, and on each request
with its tasks and system calls."""
_LINE_BYTES: Final = 64
"""The least average of a chunked body: each chunk is two lines to parse; proxies send kilobytes."""
_FIRST_LINES: Final = 64
_MOST_LINES: Final = 512


class Connection(web.RequestHandler):
    """Made by the `Entrance` for each connection that it admits."""

    __slots__ = (
        "_aiohttp_reads",
        "_body_left",
        "_content",
        "_drained",
        "_fed_bytes",
        "_is_answering",
        "_is_cut_off",
        "_is_urgent",
        "_limits",
        "_lines_left",
        "_loop_of_watch",
        "_payer",
        "_peer",
        "_requests",
        "_tracked",
        "_turn",
        "_waiting",
        "_watch",
        "tcp_transport",
    )

    def __init__(
        self,
        limits: HttpLimits,
        server: web.Server,
        loop: asyncio.AbstractEventLoop,
        tracked: TrackedConnection,
        peer: str,
    ) -> None:
        super().__init__(
            server,
            loop=loop,
            keepalive_timeout=IDLE_S,
            lingering_time=_LINGER_S,
            access_log=None,  # type: ignore[arg-type]  # None means no log, as in AppRunner
            max_headers=MAX_HEADERS,
            auto_decompress=False,
        )
        self._limits = limits
        self._loop_of_watch = loop
        self._tracked = tracked
        self._peer = peer
        self._watch: ConnectionWatch | None = None
        self._requests = Requests()
        self._body_left: int | None = 0
        self._fed_bytes = 0
        self._lines_left: float = _FIRST_LINES
        self._is_urgent = False
        """Whether the current request is urgent, and so waits for no others."""
        self._is_cut_off = False
        """Whether the connection was lost before the current request had arrived whole."""
        self._is_answering = False
        self._aiohttp_reads = True
        self._waiting: WaitingRequest | None = None
        self._payer: Payer = limits.budgets.of_guest(tracked.address)
        self._drained: asyncio.Future[None] | None = None
        self._turn: asyncio.Future[None] | None = None
        self._content: StreamReader | None = None
        """The body that was answered last; aiohttp reads and drops what of it still comes."""
        self.tcp_transport: asyncio.BaseTransport | None = None
        """asyncio's transport of the TCP socket; with TLS, `transport` is on top of it."""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self.tcp_transport = tcp = cast("asyncio.Transport", transport)
        if self._tracked not in self._limits.connections:  # already displaced
            tcp.abort()
            return
        self._watch = ConnectionWatch(self._limits, self._loop_of_watch, tcp, self._tracked)
        # Writing waits until the kernel has taken everything, so that a client that does not read
        # holds no more of our memory than one piece of an answer.
        tcp.set_write_buffer_limits(high=1, low=0)
        super().connection_made(transport)

    # --- receiving ---------------------------------------------------------------------------

    def data_received(self, data: bytes) -> None:
        """Buffer data until its turn; aiohttp calls this without data to go on parsing."""
        if not data or self._watch is None:
            super().data_received(data)
            return
        began_s = time.thread_time() - _PIECE_S
        self._watch.note_data()
        self._requests.add(data)
        self._queue_next()
        self._note_held()
        self._charge(began_s)

    def read_by_tls(self, read: Callable[[], None]) -> None:
        """Charge the time that TLS takes to `read`, even if that yields no HTTP."""
        turnstile = self._limits.turnstile
        began_s, charged_s = time.thread_time(), turnstile.charged_s
        read()
        began_s += turnstile.charged_s - charged_s  # its handling was charged already
        self._charge(min(began_s, time.thread_time()))
        self._queue_next()

    def _note_held(self) -> None:
        held_bytes = self._fed_bytes + len(self._requests)
        self._limits.connections.set_held_bytes(self._tracked, held_bytes)

    def _queue_next(self) -> None:
        """Queue what aiohttp is to parse next."""
        if self._watch is None or self._waiting is not None:
            return
        if self._body_left != 0:
            if self._requests:
                self._enqueue(self._payer, self._feed_body, urgent=self._is_urgent)
        elif not self._is_answering:
            self._queue_head()
        if self._waiting is None and self._limits.turnstile.wait_s(self._payer) > 0:
            self._enqueue(self._payer, self._queue_next)
        self._pause_or_resume()

    def _queue_next_and_charge(self) -> None:
        began_s = time.thread_time()
        self._queue_next()
        self._charge(began_s)

    def _queue_head(self) -> None:
        requests = self._requests
        if requests.is_not_http:
            self._feed(requests.pop(None))  # aiohttp refuses it
        elif (head := requests.pop_head()) is not None:
            self._queue_request(head)
        elif requests.is_full:
            self._refuse(431, Sentence("request.too_large"))

    def _queue_request(self, data: bytes) -> None:
        is_trusted = self._limits.proxies.trusts(self._peer)
        head = read_head(data, self._limits.asked if is_trusted else ())
        if head.has_long_path:
            self._refuse(404, Sentence("request.no_page"))
            return
        if head.expectation.lower() not in ("", "100-continue"):
            # aiohttp would answer before our limits apply, and repeat it: 40 MB in three seconds.
            self._refuse(417, Sentence("request.expectation"))
            return
        payer, self._is_urgent = self._payer_of(head)
        if payer is None:
            self._refuse(503, Sentence("door.too_often"))
            return
        self._payer = payer
        self._is_answering = True
        self._body_left = head.body_bytes
        self._enqueue(payer, lambda: self._feed_head(data), urgent=self._is_urgent)
        if self._watch is not None:
            self._watch.is_queued = self._waiting is not None

    def _payer_of(self, head: Head) -> tuple[Payer | None, bool]:
        """Return who pays, None if their address has no room, and whether the head is urgent."""
        limits = self._limits
        address = limits.proxies.sender(self._peer, head.x_forwarded_for, head.forwarded)
        if not limits.count_for(self._tracked, address, self._loop_of_watch.time()):
            return None, False
        budgets = limits.budgets
        # Cookie names of both schemes: the scheme matters for permissions, not for the order.
        shown = replace(cookies.shown(head.cookies, "https"), said=head.said)
        may_be_known = bool(head.cookies or head.tab or head.said)
        known = budgets.who(shown, address, head.target, head.tab) if may_be_known else None
        if known is not None and (payer := budgets.of_known(known[0], address)) is not None:
            return payer, known[1]
        return budgets.of_guest(address), False

    def _enqueue(self, payer: Payer, run: Callable[[], None], *, urgent: bool = False) -> None:
        def begin() -> None:
            self._waiting = None
            began_s = time.thread_time() - (_REQUEST_S if self._is_answering else 0.0)
            run()
            self._note_held()
            self._charge(began_s)

        self._waiting = self._limits.queue.enter(payer, begin, urgent=urgent)

    def _feed_head(self, head: bytes) -> None:
        if self._watch is not None:
            self._watch.is_queued = False
        self._feed(head)
        self._feed_body()

    def _feed_body(self) -> None:
        """Pass the body on; if its end is unknown, pass everything until the answer is sent."""
        data = self._requests.pop(self._body_left)
        if self._body_left is not None:
            self._body_left -= len(data)
        elif not self._may_have_lines(data):
            self._refuse(400, Sentence("request.crumbs"))
            return
        if data:
            self._fed_bytes += len(data)
            self._feed(data)
        self._pause_or_resume()

    def _may_have_lines(self, data: bytes) -> bool:
        left = min(self._lines_left + len(data) / _LINE_BYTES, _MOST_LINES)
        self._lines_left = left - data.count(b"\n")
        return self._lines_left >= 0

    def _feed(self, data: bytes) -> None:
        # aiohttp expects no data from a connection that is closing.
        if self.transport is not None and not self.transport.is_closing():
            super().data_received(data)

    def _pause_or_resume(self) -> None:
        """Pause reading while data waits for its turn, else resume."""
        if self.transport is None or self.transport.is_closing():
            return
        if self._waiting is not None or (self._is_answering and self._requests):
            self.transport.pause_reading()
        elif self._aiohttp_reads:
            self.transport.resume_reading()

    def pause_reading(self) -> None:
        """Pause reading for aiohttp."""
        self._aiohttp_reads = False
        super().pause_reading()

    def resume_reading(self, *args: Any, **more: Any) -> None:
        """Resume reading for aiohttp, unless received data still waits for its turn.

        aiohttp calls this after each piece that it has read, whether it has paused or not.
        """
        if self._aiohttp_reads:
            return
        self._aiohttp_reads = True
        super().resume_reading(*args, **more)
        self._pause_or_resume()

    # --- sending -----------------------------------------------------------------------------

    def header_parsed(self, request: web.BaseRequest) -> bool:
        """Note that a header was parsed, as the first middleware sees; False if the client left."""
        if self._watch is None:
            return False
        self._watch.header_parsed(request)
        return True

    async def timed(self, inner: Coroutine[Any, Any, _T]) -> _T:
        """Run part of an answer: its sender pays, and its steps take turns with strangers'."""
        return await timed(inner, self._charge, self._enter)

    async def _enter(self) -> None:
        # What is left of a request that was cut off is short; waiting would keep what it holds.
        if self._is_urgent or self._is_cut_off:
            return
        self._turn = self._limits.turnstile.request_turn(self._payer)
        if self._turn is not None:
            await self._turn

    async def drained(self) -> None:
        """Wait until the kernel has all output; raises `ConnectionError` if the client is gone."""
        if self.writing_paused and self._watch is not None:
            self._drained = self._loop_of_watch.create_future()
            await self._drained
            # Not the future's own error: its traceback would hold this frame, and so the future.
            if self._watch is None:
                raise ConnectionResetError("the connection is lost")

    async def pause(self, wait_s: float) -> None:
        """Write nothing for `wait_s`; raises `ConnectionError` if the connection ends meanwhile."""
        self._drained = self._loop_of_watch.create_future()
        with suppress(TimeoutError):
            await asyncio.wait_for(self._drained, wait_s)
        if self._watch is None:
            raise ConnectionResetError("the connection is lost")

    async def _drain_helper(self) -> None:
        """Replace aiohttp's own wait by `drained`: its error would hold its frame."""
        await self.drained()

    def resume_writing(self) -> None:
        """Note that the client has read more."""
        super().resume_writing()
        if self._watch is not None:
            self._watch.note_progress()
        if self._drained is not None and not self._drained.done():
            self._drained.set_result(None)

    async def finish_response(
        self, request: web.BaseRequest, resp: web.StreamResponse, start_time: float | None
    ) -> tuple[web.StreamResponse, bool]:
        """Send the answer; then wait for the next request."""
        if self._body_left is None:
            resp.force_close()  # where the next request begins is unknown
        if self._watch is not None:
            self._content = request.content
        try:
            return await self.timed(super().finish_response(request, resp, start_time))
        finally:
            self._is_answering = False
            self._fed_bytes = 0
            self._note_held()
            if self._watch is not None:
                self._watch.answered(more=bool(self._requests))
                if not self._requests:
                    now_s = self._loop_of_watch.time()
                    self._limits.count_for(self._tracked, limit_key(self._peer), now_s)
            self._loop_of_watch.call_soon(self._queue_next_and_charge)

    def handle_error(
        self,
        request: web.BaseRequest,
        status: int = 500,
        exc: BaseException | None = None,
        message: str | None = None,
    ) -> web.StreamResponse:
        """Answer anything but HTTP briefly, with a rate-limited log line."""
        if status >= 500:
            return super().handle_error(request, status, exc, message)
        self._limits.log.info("bad request", why=type(exc).__name__, sender=request.remote)
        answer = web.json_response(
            {"error": "That is no HTTP request that this server understands."},
            status=status,
            headers={**base_headers(), "Server": "WAX"},
        )
        answer.force_close()
        return answer

    def _refuse(self, status: int, sentence: Sentence) -> None:
        """Refuse a request without parsing it, and close the connection."""
        self._limits.count_cut(f"answered {status}")
        self._requests = Requests()
        self._is_answering = True  # no further request is read
        if self.transport is None:
            return
        body = json.dumps({"error": str(sentence), "sentence": sentence.wire()}).encode()
        headers = {
            "Server": "WAX",
            "Content-Type": "application/json",
            "Content-Length": str(len(body)),
        }
        lines = [f"HTTP/1.1 {status} Refused", "Connection: close"]
        lines += [f"{name}: {value}" for name, value in {**base_headers(), **headers}.items()]
        self.transport.write("\r\n".join([*lines, "", ""]).encode() + body)
        self.transport.close()

    def connection_lost(self, exc: BaseException | None) -> None:
        """Clean up, and make room for another."""
        if self._waiting is not None:
            self._waiting.cancel()
            self._waiting = None
        if self._watch is not None:
            self._watch.end()
            self._watch = None
        task, request = self._task_handler, self._current_request
        self._is_cut_off = request is not None and not request.content.is_eof()
        for waits_for in (self._turn if self._is_cut_off else None, self._drained):
            if waits_for is not None and not waits_for.done():
                waits_for.set_result(None)
        self._requests = Requests()
        if self._content is not None:
            self._content.feed_eof()
            self._content = None
        super().connection_lost(exc)
        if task is not None and request is not None:
            # A body that a handler still awaits holds the error, whose traceback holds the body.
            error = request.content.exception()
            task.add_done_callback(lambda _: _forget_frames(error))
        if self.tcp_transport is not None:
            break_circle(self.tcp_transport)
            self.tcp_transport = None

    def _charge(self, began_s: float) -> None:
        self._limits.turnstile.charge(self._payer, began_s)


def _forget_frames(error: BaseException | type[BaseException] | None) -> None:
    if isinstance(error, BaseException):
        error.with_traceback(None)
