"""Raw and slow connections: each has a timeout, and everybody else is served meanwhile."""

from __future__ import annotations

import asyncio
import errno
import gc
import json
import logging
import os
import socket
import ssl
import struct
import time
import weakref
from asyncio import sslproto
from collections import Counter
from contextlib import asynccontextmanager, suppress
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any, Final

import pytest
from aiohttp import web
from tests.turned_clock import TurnedClock, turn_loop
from tests.until import async_until

from wax.clock import SystemClock
from wax.config.server import ServerSettings
from wax.edge import turnstile
from wax.errors import StartError
from wax.web import built_page, connection, connection_limits, listening, tls, tls_gate, watch
from wax.web.certificate import self_signed
from wax.web.entrance import Entrance
from wax.web.guards import Guards
from wax.web.routes import _tell_errors
from wax.web.tls import make_tls

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Sequence
    from pathlib import Path

    from wax.access.access import Shown
    from wax.clock import Clock
    from wax.web.connection_limits import TrackedConnection
    from wax.web.request_budgets import Who

pytestmark = pytest.mark.system

READ_S: Final = 60.0
IDLE_S: Final = 120.0
"""These timeouts expire when a test turns the clock, not before."""
GET: Final = b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n"
POST: Final = b"POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 20\r\n\r\n"
KNOWN: Final = GET[:-2] + b"Cookie: wax-id=ada\r\n\r\n"
LARGE: Final = 20_000_000


@pytest.fixture(autouse=True)
def _long_times(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(watch._LASTS_S, "reading", READ_S)
    monkeypatch.setitem(watch._LASTS_S, "idle", IDLE_S)
    monkeypatch.setitem(watch._LASTS_S, "answering", IDLE_S)
    monkeypatch.setattr(connection, "_LINGER_S", 0.1)
    monkeypatch.setattr(connection, "IDLE_S", 10 * IDLE_S)  # which is aiohttp's own
    monkeypatch.setattr(tls_gate, "READ_S", READ_S / 2)  # asyncio's own is READ_S


@pytest.fixture
def turn(monkeypatch: pytest.MonkeyPatch) -> Callable[[float], None]:
    """Return a function that advances the loop's clock by seconds."""
    return lambda by_s: turn_loop(by_s, monkeypatch)


class Pace:
    """Controls a slow handler."""

    def __init__(self) -> None:
        self.thinks, self.goes_on = asyncio.Event(), asyncio.Event()


PACE: Final = web.AppKey("pace", Pace)


async def _echo(request: web.Request) -> web.Response:
    return web.json_response({"read": len(await request.read())})


async def _large(request: web.Request) -> web.Response:
    return web.Response(body=bytes(LARGE))


async def _pieces(request: web.Request) -> web.StreamResponse:
    answer = web.StreamResponse()
    await answer.prepare(request)
    assert isinstance(request.protocol, connection.Connection)
    for _ in range(LARGE // 10_000):
        await answer.write(bytes(10_000))
        await request.protocol.drained()
    return answer


async def _paced(request: web.Request) -> web.StreamResponse:
    answer = web.StreamResponse()
    await answer.prepare(request)
    assert isinstance(request.protocol, connection.Connection)
    await answer.write(b"one piece")
    await request.protocol.pause(3600.0)
    return answer


async def _slow(request: web.Request) -> web.Response:
    await request.read()
    request.app[PACE].thinks.set()
    await request.app[PACE].goes_on.wait()
    return web.Response(text="at last")


@asynccontextmanager
async def open_entrance(
    who: Who = lambda *_: None,
    clock: Clock | None = None,
    more: Sequence[web.RouteDef] = (),
    has_people_at: Callable[[str], bool] = lambda _: False,
    **settings: Any,
) -> AsyncIterator[Entrance]:
    server = ServerSettings(host="127.0.0.1", port=0, **settings)
    clock = clock or SystemClock()
    guards = Guards(server, clock)
    application = web.Application(middlewares=[_tell_errors, *guards.middlewares])
    application[PACE] = Pace()
    application.on_response_prepare.append(guards.add_headers)
    application.add_routes(
        [
            web.get("/", _echo),
            web.post("/", _echo),
            web.get("/large", _large),
            web.get("/pieces", _pieces),
            web.get("/paced", _paced),
            web.post("/slow", _slow),
            *more,
        ]
    )
    entrance = Entrance(
        application, server, clock, make_tls(server, clock), who=who, has_people_at=has_people_at
    )
    await entrance.open()
    try:
        yield entrance
    finally:
        await entrance.close()
        await async_until(lambda: len(entrance.limits.connections) == 0)


async def _until_closed(
    port: int, *pieces: bytes, drip: bytes = b"", context: ssl.SSLContext | None = None
) -> bytes:
    """Send pieces, then `drip` repeatedly; return all output until the connection is closed."""
    reader, writer = await asyncio.open_connection(
        "127.0.0.1", port, ssl=context, server_hostname="localhost" if context else None
    )
    said = b""

    async def send() -> None:
        for piece in pieces:
            writer.write(piece)
            await asyncio.sleep(0.05)
        while drip:
            writer.write(drip)
            await asyncio.sleep(0.05)

    sending = asyncio.create_task(send())
    try:
        with suppress(ConnectionError):
            while more := await reader.read(65_536):
                said += more
        return said
    finally:
        sending.cancel()
        with suppress(asyncio.CancelledError, ConnectionError):
            await sending
        writer.transport.abort()


def _unread(port: int, more: bytes = b"") -> socket.socket:
    """Request much and read nothing, with a receive buffer so small that each read shows."""
    made = socket.socket()
    made.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 16_384)
    made.connect(("127.0.0.1", port))
    made.sendall((GET.replace(b"/ ", b"/pieces ", 1)[:-2] + more + b"\r\n") * 20)
    return made


def _states(entrance: Entrance) -> list[str]:
    """Return the state of each connection."""
    return [one.state for own in entrance.limits.connections._by_address.values() for one in own]


def _is_of_aiohttp(task: asyncio.Task[Any]) -> bool:
    """Whether it serves a connection or a request."""
    return getattr(task.get_coro(), "__qualname__", "").startswith("RequestHandler.")


async def _until_open(entrance: Entrance, number: int) -> None:
    await async_until(lambda: len(entrance.limits.connections) >= number)


async def _only_one(entrance: Entrance) -> connection.Connection:
    """Wait for the only connection, and return it."""
    server: Any = entrance._runner.server
    await async_until(lambda: len(server.connections) > 0)
    (one,) = server.connections
    assert isinstance(one, connection.Connection)
    return one


async def _get(port: int, request: bytes = GET, **more: Any) -> bytes:
    reader, writer = await asyncio.open_connection("127.0.0.1", port, **more)
    try:
        writer.write(request)
        return await reader.readuntil(b"}")
    finally:
        writer.transport.abort()
        await asyncio.sleep(0.02)


async def test_slow_connections_are_cut(turn: Callable[[float], None]) -> None:
    """Silent or dripping clients, in header or body, are closed in time; others are served."""
    async with open_entrance() as entrance:
        port = entrance.port
        slow = [
            _until_closed(port),
            _until_closed(port, b"G"),
            _until_closed(port, GET[:-2]),
            _until_closed(port, GET[:-2], drip=b"X"),
            _until_closed(port, drip=b"\r\n"),
            _until_closed(port, POST),
            _until_closed(port, POST, drip=b"y"),
            _until_closed(
                port, GET[:-2] + b"Transfer-Encoding: chunked\r\n\r\n", drip=b"1\r\ny\r\n"
            ),
        ]
        cutting = asyncio.gather(*slow)
        await _until_open(entrance, len(slow))
        for _ in range(5):
            assert b'{"read": 0}' in await _get(port)
        assert (cutting.done(), entrance.limits.status()["cut"]) == (False, 0)
        turn(READ_S)
        assert await cutting == [b""] * len(slow)
        assert entrance.limits.status()["cut"] >= len(slow)


async def test_half_a_header_after_a_good_request_times_out(turn: Callable[[float], None]) -> None:
    """It has no more time than the first header of a connection."""
    async with open_entrance() as entrance:
        for pieces, drip in (
            ((GET + GET[:-2],), b""),
            ((GET + GET[:-2],), b"X"),
            ((GET, GET[:-2]), b"X"),
            ((GET, b"\r\n"), b"\r\n"),
        ):
            closing = asyncio.create_task(_until_closed(entrance.port, *pieces, drip=drip))
            one = await _only_one(entrance)
            await async_until(lambda one=one: one._request_count == 1 and not one._is_answering)  # type: ignore[misc]
            await async_until(lambda: _states(entrance) == ["reading"])
            turn(READ_S)
            assert (await closing).count(b"200 OK") == 1


async def _all_answered(entrance: Entrance, requests: int) -> None:
    """Wait until the only connection has had so many answers, and is idle."""
    one = await _only_one(entrance)
    await async_until(lambda: one._request_count == requests and _states(entrance) == ["idle"])


async def test_idle_connections_are_kept_for_a_while(turn: Callable[[float], None]) -> None:
    """A browser's next request finds the connection open; after the timeout it is closed."""
    async with open_entrance() as entrance:
        reader, writer = await asyncio.open_connection("127.0.0.1", entrance.port)
        for number in (1, 2):
            writer.write(GET)
            assert b"200 OK" in await reader.readuntil(b"}")
            await _all_answered(entrance, number)
            turn(number * IDLE_S / 2)
        assert await reader.read() == b""
        writer.transport.abort()
        closing = asyncio.create_task(_until_closed(entrance.port, GET + GET + GET))
        await _all_answered(entrance, 3)
        turn(IDLE_S)
        assert (await closing).count(b"200 OK") == 3


async def test_a_handler_may_take_its_time(turn: Callable[[float], None]) -> None:
    """The short timeout is for the client, not for our own work."""
    async with open_entrance() as entrance:
        pace = entrance._runner.app[PACE]
        half = POST.replace(b"/ ", b"/slow ") + b"y" * 10
        for pieces in ((half + b"y" * 10,), (half, b"y" * 10)):
            closing = asyncio.create_task(_until_closed(entrance.port, *pieces))
            await pace.thinks.wait()
            turn(READ_S + 1)
            await asyncio.sleep(0.01)
            pace.goes_on.set()
            await _all_answered(entrance, 1)
            turn(IDLE_S)
            assert b"at last" in await closing
            pace.thinks.clear()
            pace.goes_on.clear()


async def test_a_client_that_does_not_read_times_out(turn: Callable[[float], None]) -> None:
    """An answer that nobody reads is not kept for ever."""
    async with open_entrance() as entrance:
        reader, writer = await asyncio.open_connection("127.0.0.1", entrance.port, limit=1000)
        writer.write(GET.replace(b"/ ", b"/large ", 1))
        await async_until(lambda: _states(entrance) == ["answering"])
        turn(IDLE_S)
        await async_until(lambda: len(entrance.limits.connections) == 0)
        writer.transport.abort()
        del reader


async def test_one_address_has_its_share(turn: Callable[[float], None]) -> None:
    """Beyond its share, idle connections make room first, then silent ones."""
    async with open_entrance(max_connections_per_address=4) as entrance:
        idle = asyncio.create_task(_until_closed(entrance.port, GET))
        await async_until(lambda: _states(entrance) == ["idle"])
        silent = [asyncio.create_task(_until_closed(entrance.port)) for _ in range(4)]
        assert b"200 OK" in await idle
        assert entrance.limits.connections.displaced == 1, "the idle one has made room"
        await _until_open(entrance, 4)
        assert b'{"read": 0}' in await _get(entrance.port)
        assert (entrance.limits.connections.displaced, entrance.limits.connections.refused) == (
            2,
            0,
        )
        turn(READ_S)
        await asyncio.gather(*silent)


async def test_nothing_is_parsed_before_its_turn() -> None:
    """Of twenty requests in one piece, the second begins when the first was answered."""
    async with open_entrance() as entrance:
        reader, writer = await asyncio.open_connection("127.0.0.1", entrance.port)
        slow = POST.replace(b"/ ", b"/slow ") + b"y" * 20
        writer.write(slow + GET * 19)
        one = await _only_one(entrance)
        await async_until(lambda: len(one._requests) == 19 * len(GET))
        assert one._request_count == 1
        entrance._runner.app[PACE].goes_on.set()
        said = b""
        while said.count(b'{"read": 0}') < 19:
            said += await reader.read(9999)
        assert said.startswith(b"HTTP/1.1 200")
        writer.transport.abort()
        await asyncio.sleep(0.05)


async def test_data_after_the_end_is_no_error() -> None:
    """A request that arrives when its connection is already aborted raises nothing."""
    errors: list[dict[str, Any]] = []
    asyncio.get_running_loop().set_exception_handler(lambda _, found: errors.append(found))
    async with open_entrance() as entrance:
        _, writer = await asyncio.open_connection("127.0.0.1", entrance.port)
        one = await _only_one(entrance)
        assert one.transport is not None
        one.transport.abort()
        one.data_received(GET)
        await asyncio.sleep(0.05)
        writer.transport.abort()
        del one
        gc.collect()
    assert errors == []


@pytest.mark.parametrize("https", [False, True])
async def test_a_connection_displaced_as_it_begins_is_closed(
    https: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Displacing a connection before asyncio has set it up raises nothing."""
    monkeypatch.setenv("STATE_DIRECTORY", str(tmp_path))
    errors: list[dict[str, Any]] = []
    asyncio.get_running_loop().set_exception_handler(lambda _, found: errors.append(found))
    async with open_entrance(https=https) as entrance:
        begin = entrance._begin

        def displaced(made: socket.socket, tracked: TrackedConnection, *more: Any) -> None:
            begin(made, tracked, *more)
            entrance.limits.connections.leave(tracked)
            tracked.close()

        monkeypatch.setattr(entrance, "_begin", displaced)
        assert await _until_closed(entrance.port, GET) == b""
        gc.collect()
    assert errors == []


@pytest.mark.parametrize("https", [False, True])
@pytest.mark.parametrize(
    "begun",
    [
        *(b"", GET, POST, POST.replace(b"/ ", b"/unknown ", 1)),
        *(b"GET " + path + GET[5:] for path in (b"/pieces", b"/large", b"/paced")),
    ],
)
async def test_a_lost_connection_leaves_nothing(
    https: bool, begun: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever a connection was doing, its memory is freed at once, and not by the collector."""
    monkeypatch.setenv("STATE_DIRECTORY", str(tmp_path))
    monkeypatch.setattr(connection, "_LINGER_S", READ_S)
    async with open_entrance(https=https) as entrance:
        context = _trusting(tmp_path / "certificate.pem") if https else None
        gc.collect()
        gc.disable()
        try:
            _, writer = await asyncio.open_connection("127.0.0.1", entrance.port, ssl=context)
            writer.write(begun)
            served = await _only_one(entrance)
            await asyncio.sleep(0.1)  # it is being served now
            left = [weakref.ref(one) for one in (served.transport, served.tcp_transport)]
            del served
            writer.transport.abort()
            await async_until(lambda: len(entrance.limits.connections) == 0)
            await async_until(lambda: [one() for one in left] == [None, None])
            kept = [one for one in gc.get_objects() if type(one) is connection.Connection]
            assert not kept
        finally:
            gc.enable()


@pytest.mark.parametrize("is_whole", [False, True])
async def test_a_request_that_was_cut_off_waits_for_no_turn(
    is_whole: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Waiting would only keep its memory; a whole one costs as much as one that is answered."""
    async with open_entrance() as entrance:
        _, writer = await asyncio.open_connection("127.0.0.1", entrance.port)
        writer.write(POST.replace(b"/ ", b"/slow ", 1) + b"y" * (19 + is_whole))
        pace = entrance._runner.app[PACE]
        if is_whole:
            await pace.thinks.wait()
        else:
            await _until_open(entrance, 1)
            lost = await _only_one(entrance)
            await async_until(lambda: lost._current_request is not None)
        monkeypatch.setattr(turnstile._Lane, "is_open", False)
        monkeypatch.setattr(turnstile, "_WOKEN", 0)
        pace.goes_on.set()
        await asyncio.sleep(0.05)
        writer.transport.abort()
        if is_whole:
            await async_until(lambda: not entrance.limits.connections)
            await asyncio.sleep(0.05)
            assert any(map(_is_of_aiohttp, asyncio.all_tasks()))
            monkeypatch.setattr(turnstile, "_WOKEN", 1)
        await async_until(lambda: not any(map(_is_of_aiohttp, asyncio.all_tasks())))


async def test_a_file_is_paced_for_a_while(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It goes out in small pieces with pauses; then the rest is not paced, but counted."""
    counted: list[int] = []
    paused_s: list[float] = []

    async def pause(_: connection.Connection, wait_s: float) -> None:
        paused_s.append(wait_s)
        if len(paused_s) == 3:
            monkeypatch.setattr(built_page, "_PACED_S", 0.0)

    def sent(size_bytes: int) -> float:
        counted.append(size_bytes)
        return 0.5

    async def file(request: web.Request) -> web.StreamResponse:
        made = built_page._file(bytes(1000), "text/plain")
        return await built_page._send(request, made, {}, sent)

    monkeypatch.setattr(connection.Connection, "pause", pause)
    async with open_entrance(more=[web.get("/file", file)]) as entrance:
        for _ in range(2):
            asked = b"GET /file" + GET[5:-2] + b"Connection: close\r\n\r\n"
            answer = await _until_closed(entrance.port, asked)
            assert answer.endswith(bytes(1000))
    assert paused_s == [0.5] * 4
    assert counted == [200] * 5 + [16_384]


async def test_oversized_headers_are_refused() -> None:
    """More than 16 KiB get 431, with a sentence; thousands of cookies below it are accepted."""
    async with open_entrance() as entrance:
        cookies = b"Cookie: " + b"a=1; " * 1000 + b"\r\n"
        many = GET[:-2] + cookies * 3 + b"\r\n"
        assert b'{"read": 0}' in await _get(entrance.port, many)
        for request in (GET[:-2] + cookies * 4 + b"\r\n", b"GET /" + b"a" * 20_000):
            said = await _until_closed(entrance.port, request)
            head, _, body = said.partition(b"\r\n\r\n")
            assert head.startswith(b"HTTP/1.1 431")
            assert b"nosniff" in head
            assert "cookies" in json.loads(body)["error"]
        assert entrance.limits.status()["cut"] == 2


async def test_only_a_known_expectation_is_answered() -> None:
    """A request with any other is refused, and its text is not repeated."""
    async with open_entrance() as entrance:
        said = await _until_closed(
            entrance.port, GET[:-2] + b"Expect: " + b"x" * 7000 + b"\r\n\r\n"
        )
        assert said.startswith(b"HTTP/1.1 417")
        assert b"nosniff" in said
        assert b"xxx" not in said
        assert b'{"read": 0}' in await _get(
            entrance.port, GET[:-2] + b"Expect: 100-continue\r\n\r\n"
        )


async def test_after_a_body_of_unknown_end_the_connection_closes() -> None:
    """No request after a chunked body, or after two lengths, is answered."""
    chunked = GET[:-2].replace(b"GET", b"POST") + b"Transfer-Encoding: chunked\r\n\r\n"
    async with open_entrance() as entrance:
        for body in (b"3;a=b;c=d\r\nyyy\r\n0\r\n\r\n", b"1\r\ny\r\n" * 3 + b"0\r\n\r\n"):
            said = await _until_closed(entrance.port, chunked + body + GET)
            assert (said.count(b"200 OK"), said.count(b'{"read": 3}')) == (1, 1)
        doubt = POST.replace(b"\r\n\r\n", b"\r\nContent-Length: 20\r\n\r\n")
        said = await _until_closed(entrance.port, doubt + b"y" * 20 + GET)
        assert said.count(b"HTTP/1.") == 1


async def test_incomplete_bodies_make_room() -> None:
    """Whatever their form, their total is limited; answered ones no longer count."""
    async with open_entrance(max_connections=20, max_connections_per_address=16) as entrance:
        port, connections = entrance.port, entrance.limits.connections
        large = POST.replace(b": 20", b": 50000") + b"y" * 50_000
        whole = asyncio.create_task(_until_closed(port, large * 5 + GET * 4 + POST + b"y" * 20))
        one = await _only_one(entrance)
        await _all_answered(entrance, 10)
        await async_until(lambda: one._tracked.state == "idle")
        assert (one._tracked.held_bytes, connections.displaced) == (0, 0)
        chunked = POST.replace(b"Content-Length: 20", b"Transfer-Encoding: chunked")
        halves = (large[:-1], chunked + b"c350\r\n" + b"y" * 49_999)
        greedy = [asyncio.create_task(_until_closed(port, half)) for half in halves * 2]
        first, rest = await asyncio.wait(greedy, return_when=asyncio.FIRST_COMPLETED)
        assert [task.result() for task in first] == [b""]
        assert (len(rest), connections.displaced) == (3, 1)
        for task in (*rest, whole):
            task.cancel()
        await asyncio.wait([*rest, whole])


async def test_a_body_in_tiny_chunks_is_refused(caplog: pytest.LogCaptureFixture) -> None:
    """Thousands of one-byte chunks are thousands of lines to parse; a proxy's are longer."""
    async with open_entrance() as entrance:
        for size, status in ((1, b"400"), (40, b"400"), (200, b"200")):
            chunk = b"%x\r\n%s\r\n" % (size, b"y" * size)
            body = b"Transfer-Encoding: chunked\r\n\r\n" + chunk * 200 + b"0\r\n\r\n"
            said = await _until_closed(entrance.port, POST.split(b"Content")[0] + body)
            assert said.startswith(b"HTTP/1.1 " + status)
            assert said.count(b"HTTP/1.1") == 1
            assert (b"Content-Length" in said.partition(b"{")[2]) == (status == b"400")
    assert not [record for record in caplog.records if record.levelno >= logging.ERROR]


async def test_resuming_costs_nothing_while_reading_is_not_paused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Reading is resumed after each piece of a body, even while data waits in the queue."""
    async with open_entrance() as entrance:
        _, writer = await asyncio.open_connection("127.0.0.1", entrance.port)
        writer.write(POST.replace(b"/ ", b"/slow ") + b"y" * 20 + GET)
        one = await _only_one(entrance)
        await async_until(lambda: len(one._requests) == len(GET))
        turned: list[object] = []
        assert one.transport is not None
        monkeypatch.setattr(one.transport._loop, "_add_reader", lambda *of: turned.append(of))  # type: ignore[attr-defined]
        for _ in range(100):
            one.resume_reading()
        assert turned == []
        writer.transport.abort()
        monkeypatch.undo()
        await asyncio.sleep(0.05)


@pytest.mark.parametrize(
    "more",
    [
        b"Expect: 100-continue\r\n",
        b"Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n",
        b"Connection: Upgrade, HTTP2-Settings\r\nUpgrade: h2c\r\nHTTP2-Settings: AAMA\r\n",
    ],
)
async def test_expect_and_upgrade_are_answered(more: bytes, turn: Callable[[float], None]) -> None:
    """A request with such a header is served like any other, and so is the next one."""
    async with open_entrance() as entrance:
        request = POST[:-2] + more + b"\r\n" + b"y" * 20
        closing = asyncio.create_task(_until_closed(entrance.port, request + GET))
        await _all_answered(entrance, 2)
        turn(IDLE_S)
        said = await closing
        assert said.count(b"HTTP/1.1 200") == 2
        assert b'{"read": 20}' in said


async def test_clients_that_do_not_read_make_room(turn: Callable[[float], None]) -> None:
    """If nobody reads their answers, the oldest of the address with the most is cut off."""
    async with open_entrance(max_connections=16, max_connections_per_address=16) as entrance:
        greedy = [_unread(entrance.port) for _ in range(16)]
        await async_until(lambda: _states(entrance) == ["answering"] * 16)
        turn(connection_limits._ANSWERS_S)
        for _ in range(3):
            assert b'{"read": 0}' in await _get(entrance.port)
            await asyncio.sleep(0.05)
        assert 1 <= entrance.limits.connections.displaced <= 3
        assert entrance.limits.connections.refused == 0
        for one in greedy:
            one.close()
        await asyncio.sleep(0.1)


async def test_a_stalled_answer_is_cut_off(
    monkeypatch: pytest.MonkeyPatch, turn: Callable[[float], None]
) -> None:
    """It ends long before the timeout of a slow one, which goes on while it is read."""
    monkeypatch.setitem(watch._LASTS_S, "answering", 6 * watch.STALL_S)
    async with open_entrance() as entrance:
        slow, still = _unread(entrance.port), _unread(entrance.port)
        await async_until(lambda: _states(entrance) == ["answering"] * 2)
        while entrance.limits.status()["cut"] == 0:
            slow.recv(60_000)
            await asyncio.sleep(0.1)  # all buffers are full again
            turn(watch.STALL_S)
            await asyncio.sleep(0)
        await async_until(lambda: len(entrance.limits.connections) == 1)
        assert entrance.limits.status()["cut"] == 1
        slow.close()
        still.close()
        await asyncio.sleep(0.05)


def _who(shown: Shown, *_: str) -> tuple[str, bool] | None:
    return (shown.identity, False) if shown.identity else None


async def test_a_new_connection_from_where_somebody_watches_does_not_wait() -> None:
    """Its client may want to stop the robot, when strangers there have used up the budget."""
    clock = TurnedClock()
    async with open_entrance(_who, clock, has_people_at="127.0.0.1".__eq__) as entrance:
        flood = entrance.limits.budgets.of_guest("127.0.0.1")
        for _ in range(9):
            entrance.limits.turnstile.charge(flood, time.thread_time() - 0.5)
        async with asyncio.timeout(5):
            assert b'{"read": 0}' in await _get(entrance.port, KNOWN)


async def test_a_connection_closed_before_its_turn_is_not_served(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A client that connects and resets a thousand times a second costs next to nothing."""
    clock = TurnedClock()
    made: list[object] = []
    begins = connection.Connection.connection_made

    def begun(self: connection.Connection, transport: asyncio.BaseTransport) -> None:
        made.append(transport)
        begins(self, transport)

    monkeypatch.setattr(connection.Connection, "connection_made", begun)
    async with open_entrance(clock=clock) as entrance:
        flood = entrance.limits.budgets.of_guest("127.0.0.1")
        for _ in range(9):
            entrance.limits.turnstile.charge(flood, time.thread_time() - 0.5)
        for linger in (struct.pack("ii", 1, 0), struct.pack("ii", 0, 0)):
            with socket.create_connection(("127.0.0.1", entrance.port)) as one:
                one.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, linger)
        await _until_open(entrance, 2)
        clock.time_s += READ_S
        assert b'{"read": 0}' in await _get(entrance.port)
        await async_until(lambda: len(entrance.limits.connections) == 0)
    assert len(made) == 1


async def test_many_are_accepted_in_a_pass() -> None:
    """In the kernel's queue everybody waits behind a flood, since we cannot reorder it."""
    accepted: list[socket.socket] = []
    found = listening.Listening("127.0.0.1", 0, lambda made, _: accepted.append(made))
    clients = [socket.create_connection(("127.0.0.1", found.port)) for _ in range(12)]
    for _ in range(3):
        await asyncio.sleep(0)
    found.close()
    assert len(accepted) == len(clients)
    for one in accepted + clients:
        one.close()


async def test_a_client_pays_for_checking_its_cookies(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It pays for each request, even for those in one piece with the first."""

    def slowly(shown: Shown, *_: str) -> tuple[str, bool] | None:
        until_s = time.thread_time() + 0.02
        while time.thread_time() < until_s:
            pass
        return _who(shown)

    charged_s: list[float] = []
    async with open_entrance(slowly) as entrance:
        turnstile = entrance.limits.turnstile
        monkeypatch.setattr(
            turnstile, "charge", lambda _, began_s: charged_s.append(time.thread_time() - began_s)
        )
        reader, writer = await asyncio.open_connection("127.0.0.1", entrance.port)
        writer.write(KNOWN * 3)
        for _ in range(3):
            await reader.readuntil(b"}")
        writer.transport.abort()
        await asyncio.sleep(0.05)
    assert sum(charged_s) >= 3 * 0.02


async def test_known_people_are_served_beside_a_flood() -> None:
    """Strangers at their address wait for its budget; their own request does not."""
    clock = TurnedClock()
    async with open_entrance(_who, clock) as entrance:
        flood = entrance.limits.budgets.of_guest("127.0.0.1")
        reader, writer = await asyncio.open_connection("127.0.0.1", entrance.port)
        writer.write(GET)
        await reader.readuntil(b"}")
        for _ in range(9):
            entrance.limits.turnstile.charge(flood, time.thread_time() - 0.5)
        waiting = asyncio.create_task(_get(entrance.port))
        await _until_open(entrance, 2)
        writer.write(KNOWN)
        assert b'{"read": 0}' in await reader.readuntil(b"}")
        assert not waiting.done(), "a stranger of that address waits"
        clock.time_s += READ_S
        assert b'{"read": 0}' in await waiting
        writer.transport.abort()
        await asyncio.sleep(0.05)


@pytest.mark.parametrize("is_urgent", [False, True])
async def test_few_steps_of_strangers_requests_share_a_pass(is_urgent: bool) -> None:
    """However many requests are answered at once, few steps run; urgent ones do not wait."""
    loop = asyncio.get_running_loop()
    steps = Counter[int]()
    passes = 0

    def count() -> None:
        nonlocal passes
        passes += 1
        counting[0] = loop.call_soon(count)

    async def works(_: web.Request) -> web.Response:
        for _step in range(4):
            steps[passes] += 1
            until_s = time.thread_time() + 0.003
            while time.thread_time() < until_s:
                pass
            await goes_on.wait() if passes == 0 else await asyncio.sleep(0)
        return web.Response(text="{}")

    goes_on = asyncio.Event()
    request = KNOWN.replace(b"/", b"/works", 1)
    more = [web.get("/works", works)]
    async with open_entrance(lambda *_: ("ada", is_urgent), TurnedClock(), more) as entrance:
        asking = [asyncio.create_task(_get(entrance.port, request)) for _ in range(8)]
        await async_until(lambda: steps[0] == 8)
        counting = [loop.call_soon(count)]
        goes_on.set()
        await asyncio.gather(*asking)
        counting[0].cancel()
    del steps[0]
    assert steps.total() == 8 * 3
    assert (max(steps.values()) <= 3) is not is_urgent


async def test_a_queued_request_does_not_time_out(turn: Callable[[float], None]) -> None:
    """A class behind one address is answered, even by a small machine."""
    clock = TurnedClock()
    async with open_entrance(clock=clock) as entrance:
        flood = entrance.limits.budgets.of_guest("127.0.0.1")
        reader, writer = await asyncio.open_connection("127.0.0.1", entrance.port)
        one = await _only_one(entrance)
        for _ in range(9):
            entrance.limits.turnstile.charge(flood, time.thread_time() - 0.5)
        writer.write(GET)
        await async_until(lambda: one._watch is not None and one._watch.is_queued)
        turn(READ_S)
        await asyncio.sleep(0.01)
        clock.time_s += READ_S
        assert b'{"read": 0}' in await reader.readuntil(b"}")
        writer.transport.abort()
        await asyncio.sleep(0.05)


async def test_a_dripping_client_is_not_read_beyond_its_budget() -> None:
    """A header in a thousand pieces is work as well: it is queued like a request."""
    async with open_entrance(clock=TurnedClock()) as entrance:
        flood = entrance.limits.budgets.of_guest("127.0.0.1")
        _, writer = await asyncio.open_connection("127.0.0.1", entrance.port)
        one = await _only_one(entrance)
        transport = one.transport
        assert transport is not None
        writer.write(b"G")
        await asyncio.sleep(0.05)
        assert transport.is_reading()
        for _ in range(4):
            entrance.limits.turnstile.charge(flood, time.thread_time() - 0.5)
        writer.write(b"E")
        await async_until(lambda: not transport.is_reading())
        assert one._waiting is not None
        writer.transport.abort()


async def test_behind_a_proxy_each_client_has_a_share() -> None:
    """One that never reads gets no more connections than without a proxy; others are answered."""
    async with open_entrance(
        trusted_proxies=["127.0.0.1"], max_connections_per_address=4
    ) as entrance:
        greedy = [_unread(entrance.port, b"X-Forwarded-For: 192.0.2.66\r\n") for _ in range(6)]
        limits = entrance.limits.connections
        await async_until(lambda: limits.refused + limits.displaced == 2)
        assert limits.count_of("192.0.2.66") == 4
        guest = GET[:-2] + b"X-Forwarded-For: 192.0.2.7\r\n\r\n"
        assert b'{"read": 0}' in await _get(entrance.port, guest)
        for one in greedy:
            one.close()
        await asyncio.sleep(0.05)


async def test_without_descriptors_nothing_spins(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """Accepting pauses for a moment, logs that once, and then goes on."""
    monkeypatch.setattr(listening, "_PAUSE_S", 0.2)
    tries = 0

    class Full(socket.socket):
        def accept(self) -> tuple[socket.socket, Any]:
            nonlocal tries
            tries += 1
            if tries <= 2:
                raise OSError(errno.EMFILE, "Too many open files")
            return super().accept()

    def create_server(address: Any, *, family: int, backlog: int) -> socket.socket:
        made = Full(family, socket.SOCK_STREAM)
        made.bind(address)
        made.listen(backlog)
        return made

    monkeypatch.setattr(socket, "create_server", create_server)
    async with open_entrance() as entrance:
        began_s = time.monotonic()
        assert b'{"read": 0}' in await _get(entrance.port)
        assert time.monotonic() - began_s >= 0.4
    assert tries <= 5


async def test_a_full_server_still_answers(turn: Callable[[float], None]) -> None:
    """If silent clients hold all connections, a request still gets through at once."""
    async with open_entrance(max_connections=16) as entrance:
        silent = [asyncio.create_task(_until_closed(entrance.port)) for _ in range(16)]
        await _until_open(entrance, 16)
        for _ in range(5):
            assert b'{"read": 0}' in await _get(entrance.port)
        assert entrance.limits.connections.displaced >= 1
        turn(READ_S)
        await asyncio.gather(*silent)


@pytest.mark.parametrize(
    "garbage",
    [
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",
        b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
        b"GET / HTTP/9.9\r\n\r\n",
        b"GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n",
        b"GET / HTTP/1.1\r\nHost\x00: a\r\n\r\n",
        b"GET / HTTP/1.1\r\n" + b"A: b\r\n" * 100 + b"\r\n",
        b"GET / HTTP/1.1\r\nA: " + b"b" * 10_000 + b"\r\n\r\n",
        b"POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: -1\r\n\r\n",
        POST.replace(b"\r\n\r\n", b"\r\nTransfer-Encoding: chunked\r\n\r\n"),
    ],
    ids=range(9),
)
async def test_anything_but_http_is_refused(
    garbage: bytes, caplog: pytest.LogCaptureFixture
) -> None:
    """It gets a sentence and is closed, and the log gets no more than a few lines."""
    caplog.set_level(logging.DEBUG)
    async with open_entrance() as entrance:
        for _ in range(20):
            said = await _until_closed(entrance.port, garbage)
            head, _, body = said.partition(b"\r\n\r\n")
            assert head.startswith((b"HTTP/1.1 400", b"HTTP/1.0 400"))
            assert b"nosniff" in head
            assert len(json.loads(body)["error"]) > 5
    lines = [record for record in caplog.records if record.levelno >= logging.INFO]
    assert len(lines) <= 6
    assert not any(record.exc_info for record in caplog.records)


async def test_a_body_that_breaks_off_is_no_error(caplog: pytest.LogCaptureFixture) -> None:
    """A client that leaves in the middle of a body causes no error in the log."""
    async with open_entrance() as entrance:
        for _ in range(3):
            _, writer = await asyncio.open_connection("127.0.0.1", entrance.port)
            writer.write(POST + b"half")
            await asyncio.sleep(0.02)
            writer.transport.abort()
        await async_until(lambda: len(entrance.limits.connections) == 0)
    assert not [record for record in caplog.records if record.levelno >= logging.ERROR]


async def test_a_port_in_use_is_a_sentence() -> None:
    """It says what to do, and nothing is left open."""
    async with open_entrance() as entrance:
        other = Entrance(
            web.Application(), ServerSettings(host="127.0.0.1", port=entrance.port), SystemClock()
        )
        with pytest.raises(StartError, match="--port"):
            await other.open()
        await other.close()


def _trusting(chain: Path) -> ssl.SSLContext:
    return ssl.create_default_context(cafile=str(chain))


async def _shut_out(turn: Callable[[float], None], *silent: asyncio.Task[bytes]) -> list[bytes]:
    """Let the timeout of pending handshakes expire."""
    await asyncio.sleep(0.05)
    turn(READ_S / 2)
    return await asyncio.gather(*silent)


async def test_https(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, turn: Callable[[float], None]
) -> None:
    """HTTPS serves pages; plain HTTP and silent handshakes are closed in time."""
    monkeypatch.setenv("STATE_DIRECTORY", str(tmp_path))
    async with open_entrance(https=True) as entrance:
        context = _trusting(tmp_path / "certificate.pem")
        said = await _get(entrance.port, ssl=context, server_hostname="localhost")
        assert b"nosniff" in said
        assert b'{"read": 0}' in await _get(entrance.port, ssl=context, server_hostname="127.0.0.1")
        silent = asyncio.create_task(_until_closed(entrance.port))
        await _until_open(entrance, 1)
        assert await _shut_out(turn, silent) == [b""]
        assert b"200" not in await _until_closed(entrance.port, GET)
        half = asyncio.create_task(_until_closed(entrance.port, GET[:-2], context=context))
        await _only_one(entrance)
        turn(READ_S)
        assert await half == b""
        both = asyncio.create_task(_until_closed(entrance.port, GET + GET, context=context))
        await _all_answered(entrance, 2)
        turn(IDLE_S)
        assert (await both).count(b"200 OK") == 2


async def test_https_counts_handshakes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, turn: Callable[[float], None]
) -> None:
    """A client that never shakes hands counts, too, and makes room for others at its address."""
    monkeypatch.setenv("STATE_DIRECTORY", str(tmp_path))
    async with open_entrance(https=True, max_connections_per_address=4) as entrance:
        silent = [asyncio.create_task(_until_closed(entrance.port)) for _ in range(4)]
        await _until_open(entrance, 4)
        context = _trusting(tmp_path / "certificate.pem")
        assert b"200 OK" in await _get(entrance.port, ssl=context, server_hostname="localhost")
        assert (entrance.limits.connections.displaced, entrance.limits.connections.refused) == (
            1,
            0,
        )
        await _shut_out(turn, *silent)


async def test_handshakes_are_queued(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Their address pays before they begin: the signature costs more than a request."""
    monkeypatch.setenv("STATE_DIRECTORY", str(tmp_path))
    clock = TurnedClock()
    monkeypatch.setattr(clock, "wall_ms", SystemClock().wall_ms)  # by which certificates are valid
    async with open_entrance(clock=clock, https=True) as entrance:
        context = _trusting(tmp_path / "certificate.pem")
        flood = entrance.limits.budgets.of_guest("127.0.0.1")
        for _ in range(9):
            entrance.limits.turnstile.charge(flood, time.thread_time() - 0.5)
        getting = _get(entrance.port, ssl=context, server_hostname="localhost")
        waiting = asyncio.create_task(getting)
        await _until_open(entrance, 1)
        await asyncio.sleep(0.1)
        assert not waiting.done()
        clock.time_s += READ_S
        assert b"200 OK" in await waiting


@pytest.mark.parametrize("begun", [b"", POST.replace(b"/ ", b"/slow ", 1) + bytes(20)])
async def test_what_tls_keeps_to_itself_is_charged(
    begun: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whoever sends what never becomes HTTP, such as new keys, is read until they owe, no more."""
    monkeypatch.setenv("STATE_DIRECTORY", str(tmp_path))
    clock, reads = TurnedClock(), 0
    monkeypatch.setattr(clock, "wall_ms", SystemClock().wall_ms)
    read = sslproto.SSLProtocol._do_read  # type: ignore[attr-defined]

    def costly(tls: sslproto.SSLProtocol) -> None:
        nonlocal reads
        reads += 1
        until_s = time.thread_time() + 0.01
        while time.thread_time() < until_s:
            pass
        read(tls)

    async with open_entrance(clock=clock, https=True) as entrance:
        context = _trusting(tmp_path / "certificate.pem")
        _, writer = await asyncio.open_connection(
            "127.0.0.1", entrance.port, ssl=context, server_hostname="localhost"
        )
        writer.write(begun)
        served = await _only_one(entrance)
        await async_until(lambda: served._is_answering is bool(begun))
        monkeypatch.setattr(sslproto.SSLProtocol, "_do_read", costly)
        line = writer.get_extra_info("socket").fileno()
        os.write(line, b"\x17\x03\x03\x40\x00")  # a record of 16 KiB
        for _ in range(100):
            os.write(line, b"\0")
            await asyncio.sleep(0.002)
        assert 10 < reads < 60
        server_line: Any = served.tcp_transport
        assert not server_line.is_reading()
        clock.time_s += READ_S
        await async_until(server_line.is_reading)
        writer.transport.abort()


async def test_tls_reads_nothing_ahead(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What waits until a request is answered waits in the system, for all to be read in one go."""
    monkeypatch.setenv("STATE_DIRECTORY", str(tmp_path))
    async with open_entrance(https=True) as entrance:
        context = _trusting(tmp_path / "certificate.pem")
        _, writer = await asyncio.open_connection(
            "127.0.0.1", entrance.port, ssl=context, server_hostname="localhost"
        )
        writer.write(POST.replace(b"/ ", b"/slow ", 1) + bytes(20) + POST + bytes(20))
        served = await _only_one(entrance)
        await async_until(lambda: served._is_answering and bool(served._requests))
        writer.write(bytes(300_000))
        await asyncio.sleep(0.1)
        secured: Any = served.transport
        assert secured.get_read_buffer_size() < 20_000
        writer.transport.abort()


async def test_a_new_certificate_needs_no_restart(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """New files serve the next connection, and half-written ones leave the old certificate."""
    monkeypatch.setattr(tls, "_LOOK_S", 0.0)
    now = datetime.now(UTC)
    kept = self_signed(tmp_path, ["localhost"], now)
    files: dict[str, Any] = {"certificate": str(kept.chain), "key": str(kept.key)}
    async with open_entrance(**files) as entrance:
        first = _trusting(kept.chain)
        assert b"200 OK" in await _get(entrance.port, ssl=first, server_hostname="localhost")
        old_key = kept.key.read_bytes()
        kept.key.write_bytes(old_key[:50])
        assert b"200 OK" in await _get(entrance.port, ssl=first, server_hostname="localhost")
        other = self_signed(tmp_path / "other", ["localhost"], now)
        other.key.replace(kept.key)
        other.chain.replace(kept.chain)
        second = _trusting(kept.chain)
        assert b"200 OK" in await _get(entrance.port, ssl=second, server_hostname="localhost")
        with pytest.raises(ssl.SSLCertVerificationError):
            await _get(entrance.port, ssl=first, server_hostname="localhost")


async def test_a_foreign_name_is_refused_for_people_and_programs() -> None:
    """A browser gets a page with the sentence, a program gets JSON, both with status 421."""
    async with open_entrance() as entrance:
        asked = GET.replace(b"localhost", b"evil.example")
        browser = asked[:-2] + b"Accept: text/html,*/*;q=0.8\r\nConnection: close\r\n\r\n"
        said = await _until_closed(entrance.port, browser)
        assert said.startswith(b"HTTP/1.1 421")
        assert b"Content-Type: text/html" in said
        assert b"<p>" in said
        assert b"application/json" in await _get(entrance.port, asked)
