"""One HTTP connection: aiohttp's, which gives its client only so much time and work.

aiohttp parses whatever comes. Here it gets one request at a time, when its sender's turn has come
(`wax.web.request_queue`), and nothing is read meanwhile.
"""

from __future__ import annotations

import asyncio
import json
import time
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Final, TypeVar, cast

from aiohttp import web

from wax.machine.memory import break_circle
from wax.sentence import Sentence
from wax.web import cookies
from wax.web.request_head import Head, Requests, read_head
from wax.web.security_headers import always
from wax.web.senders import limited
from wax.web.timed import timed
from wax.web.watch import IDLE_S, ConnectionWatch

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine

    from wax.edge.budget import Payer
    from wax.web.connection_limits import TrackedConnection
    from wax.web.http_limits import HttpLimits
    from wax.web.request_queue import WaitingRequest

    _T = TypeVar("_T")

_LINGER_S: Final = 2.0
"""How long the rest of a body is thrown away, so that the client reads why it was refused."""
_MAX_HEADERS: Final = 64
_PIECE_S: Final = 0.00003
_REQUEST_S: Final = 0.00015
"""What the event loop spends beside what is measured: on each piece that comes, and on each request
with its tasks and system calls."""
_LINE_BYTES: Final = 64
"""On the mean, of a body in chunks, each of which is two lines to parse; proxies' are kilobytes."""
_FIRST_LINES: Final = 64
_MOST_LINES: Final = 512


class Connection(web.RequestHandler):
    """Made by the `Entrance` for each connection that may stay open."""

    __slots__ = (
        "_aiohttp_reads",
        "_body_left",
        "_drained",
        "_given_bytes",
        "_is_ahead",
        "_is_answering",
        "_limits",
        "_lines_left",
        "_loop_of_watch",
        "_payer",
        "_peer",
        "_requests",
        "_tracked",
        "_waiting",
        "_watch",
        "line",
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
            max_headers=_MAX_HEADERS,
            auto_decompress=False,
        )
        self._limits = limits
        self._loop_of_watch = loop
        self._tracked = tracked
        self._peer = peer
        self._watch: ConnectionWatch | None = None
        self._requests = Requests()
        self._body_left: int | None = 0
        self._given_bytes = 0
        self._lines_left: float = _FIRST_LINES
        self._is_ahead = False
        """Whether the request that is answered does not wait for others."""
        self._is_answering = False
        self._aiohttp_reads = True
        self._waiting: WaitingRequest | None = None
        self._payer: Payer = limits.budgets.of_guest(tracked.address)
        self._drained: asyncio.Future[None] | None = None
        self.line: asyncio.BaseTransport | None = None
        """What asyncio made of the socket; under TLS that is beneath `transport`."""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self.line = line = cast("asyncio.Transport", transport)
        if self._tracked not in self._limits.connections:  # it has made room already
            line.abort()
            return
        self._watch = ConnectionWatch(self._limits, self._loop_of_watch, line, self._tracked)
        # Whatever is written waits here until the kernel has it all, so that nobody who does not
        # read has more of our memory than one piece of an answer.
        line.set_write_buffer_limits(high=1, low=0)
        super().connection_made(transport)

    # --- what comes --------------------------------------------------------------------------

    def data_received(self, data: bytes) -> None:
        """Keep what came until its turn; aiohttp calls this without data, to go on itself."""
        if not data or self._watch is None:
            super().data_received(data)
            return
        began_s = time.thread_time() - _PIECE_S
        self._watch.received()
        self._requests.add(data)
        self._go_on()
        self._note_held()
        self._charge(began_s)

    def _note_held(self) -> None:
        held_bytes = self._given_bytes + len(self._requests)
        self._limits.connections.holds(self._tracked, held_bytes)

    def _go_on(self) -> None:
        """Get in line with what aiohttp may have next."""
        if self._watch is None or self._waiting is not None:
            return
        if self._body_left != 0:
            if self._requests:
                self._get_in_line(self._payer, self._give_body, ahead=self._is_ahead)
        elif not self._is_answering:
            self._take_head()
        self._read_or_not()

    def _go_on_with_next(self) -> None:
        began_s = time.thread_time()
        self._go_on()
        self._charge(began_s)

    def _take_head(self) -> None:
        requests = self._requests
        if requests.is_no_http:
            self._give(requests.take(None))  # which says so
        elif (head := requests.take_head()) is not None:
            self._head_came(head)
        elif requests.is_full:
            self._refuse(431, Sentence("request.too_large"))
        elif self._limits.turnstile.wait_s(self._payer) > 0:
            self._get_in_line(self._payer, self._read_or_not)

    def _head_came(self, data: bytes) -> None:
        head = read_head(data)
        payer, self._is_ahead = self._payer_of(head)
        if payer is None:
            self._refuse(503, Sentence("door.too_often"))
            return
        self._payer = payer
        self._is_answering = True
        self._body_left = head.body_bytes
        self._get_in_line(payer, lambda: self._give_head(data), ahead=self._is_ahead)
        if self._watch is not None:
            self._watch.is_in_line = self._waiting is not None

    def _payer_of(self, head: Head) -> tuple[Payer | None, bool]:
        """Return who pays, None if they may have no more, and whether they pass the others."""
        limits = self._limits
        address = limits.proxies.sender(self._peer, head.x_forwarded_for, head.forwarded)
        if not limits.is_for(self._tracked, address, self._loop_of_watch.time()):
            return None, False
        budgets = limits.budgets
        # Both schemes' names: which it is matters to what one may do, not to when.
        shown = cookies.shown(head.cookies, "https")
        known = budgets.who(shown, address, head.target) if head.cookies else None
        if known is not None and (payer := budgets.of_known(known[0], address)) is not None:
            return payer, known[1]
        return budgets.of_guest(address), False

    def _get_in_line(self, payer: Payer, run: Callable[[], None], *, ahead: bool = False) -> None:
        def begin() -> None:
            self._waiting = None
            began_s = time.thread_time() - (_REQUEST_S if self._is_answering else 0.0)
            run()
            self._note_held()
            self._charge(began_s)

        self._waiting = self._limits.queue.enter(payer, begin, ahead=ahead)

    def _give_head(self, head: bytes) -> None:
        if self._watch is not None:
            self._watch.is_in_line = False
        self._give(head)
        self._give_body()

    def _give_body(self) -> None:
        """Pass on what came of the body; of one without an end everything, until it is answered."""
        data = self._requests.take(self._body_left)
        if self._body_left is not None:
            self._body_left -= len(data)
        elif not self._may_have_lines(data):
            self._refuse(400, Sentence("request.crumbs"))
            return
        if data:
            self._given_bytes += len(data)
            self._give(data)
        self._read_or_not()

    def _may_have_lines(self, data: bytes) -> bool:
        left = min(self._lines_left + len(data) / _LINE_BYTES, _MOST_LINES)
        self._lines_left = left - data.count(b"\n")
        return self._lines_left >= 0

    def _give(self, data: bytes) -> None:
        # aiohttp does not expect anything of a connection that is about to be lost.
        if self.transport is not None and not self.transport.is_closing():
            super().data_received(data)

    def _read_or_not(self) -> None:
        """Read nothing while there is something that waits."""
        if self.transport is None or self.transport.is_closing():
            return
        if self._waiting is not None or (self._is_answering and self._requests):
            self.transport.pause_reading()
        elif self._aiohttp_reads:
            self.transport.resume_reading()

    def pause_reading(self) -> None:
        """Stop reading, as aiohttp wants."""
        self._aiohttp_reads = False
        super().pause_reading()

    def resume_reading(self, *args: Any, **more: Any) -> None:
        """Go on reading, unless it is not yet time for what has come already.

        aiohttp asks for it after each piece that it has read, whether it has paused or not.
        """
        if self._aiohttp_reads:
            return
        self._aiohttp_reads = True
        super().resume_reading(*args, **more)
        self._read_or_not()

    # --- what goes ---------------------------------------------------------------------------

    def header_came(self, request: web.BaseRequest) -> bool:
        """Go on to the body; the first middleware asks. False if the connection is lost."""
        if self._watch is None:
            return False
        self._watch.header_came(request)
        return True

    async def timed(self, inner: Coroutine[Any, Any, _T]) -> _T:
        """Run a part of answering at its sender's cost, in turn with other strangers' work."""
        return await timed(inner, self._charge, self._enter)

    async def _enter(self) -> None:
        if not self._is_ahead:
            await self._limits.turnstile.enter_request(self._payer)

    async def drained(self) -> None:
        """Wait until the kernel has all that was written; raises `ConnectionError` if it ends."""
        if self.writing_paused and self._watch is not None:
            self._drained = self._loop_of_watch.create_future()
            await self._drained
            # Not set as the future's: its traceback would hold this frame, and so the future.
            if self._watch is None:
                raise ConnectionResetError("the connection is lost")

    async def pause(self, wait_s: float) -> None:
        """Write nothing for so long; raises `ConnectionError` if the connection ends meanwhile."""
        self._drained = self._loop_of_watch.create_future()
        with suppress(TimeoutError):
            await asyncio.wait_for(self._drained, wait_s)
        if self._watch is None:
            raise ConnectionResetError("the connection is lost")

    async def _drain_helper(self) -> None:
        """Wait as `drained` does where aiohttp waits: the error of its own holds its frame."""
        await self.drained()

    def resume_writing(self) -> None:
        """Note that the client takes more."""
        super().resume_writing()
        if self._watch is not None:
            self._watch.moves()
        if self._drained is not None and not self._drained.done():
            self._drained.set_result(None)

    async def finish_response(
        self, request: web.BaseRequest, resp: web.StreamResponse, start_time: float | None
    ) -> tuple[web.StreamResponse, bool]:
        """Send the answer; then wait for the next request."""
        if self._body_left is None:
            resp.force_close()  # nobody knows where the next one would begin
        try:
            return await self.timed(super().finish_response(request, resp, start_time))
        finally:
            self._is_answering = False
            self._given_bytes = 0
            self._note_held()
            if self._watch is not None:
                self._watch.answered(more=bool(self._requests))
                if not self._requests:
                    now_s = self._loop_of_watch.time()
                    self._limits.is_for(self._tracked, limited(self._peer), now_s)
            self._loop_of_watch.call_soon(self._go_on_with_next)

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
        self._limits.log.info("bad request", why=type(exc).__name__, sender=request.remote)
        answer = web.json_response(
            {"error": "That is no HTTP request that this server understands."},
            status=status,
            headers={**always(), "Server": "WAX"},
        )
        answer.force_close()
        return answer

    def _refuse(self, status: int, sentence: Sentence) -> None:
        """Answer a request that nobody parses, and end the connection."""
        self._limits.cut(f"answered {status}")
        self._requests = Requests()
        self._is_answering = True  # nothing that comes now is read as another
        if self.transport is None:
            return
        body = json.dumps({"error": str(sentence), "sentence": sentence.wire()}).encode()
        headers = {
            "Server": "WAX",
            "Content-Type": "application/json",
            "Content-Length": str(len(body)),
        }
        lines = [f"HTTP/1.1 {status} Refused", "Connection: close"]
        lines += [f"{name}: {value}" for name, value in {**always(), **headers}.items()]
        self.transport.write("\r\n".join([*lines, "", ""]).encode() + body)
        self.transport.close()

    def connection_lost(self, exc: BaseException | None) -> None:
        """Make room for another."""
        if self._waiting is not None:
            self._waiting.leave()
            self._waiting = None
        if self._watch is not None:
            self._watch.end()
            self._watch = None
        if self._drained is not None and not self._drained.done():
            self._drained.set_result(None)
        task, request = self._task_handler, self._current_request
        super().connection_lost(exc)
        if task is not None and request is not None:
            # The body, which a handler still awaits, keeps the error, whose traceback keeps both.
            error = request.content.exception()
            task.add_done_callback(lambda _: _forget_frames(error))
        if self.line is not None:
            break_circle(self.line)
            self.line = None

    def _charge(self, began_s: float) -> None:
        self._limits.turnstile.charge(self._payer, began_s)


def _forget_frames(error: BaseException | type[BaseException] | None) -> None:
    if isinstance(error, BaseException):
        error.with_traceback(None)
