"""One attempt to post an event, whatever the receiver does."""

from __future__ import annotations

import asyncio
import socket
import threading
from contextlib import asynccontextmanager, suppress
from typing import TYPE_CHECKING

import pytest
from aiohttp.client_proto import ResponseHandler
from tests.hooks.receiver import Receiver, receiving
from tests.tls_server import pair, server_context, serving
from tests.turned_clock import turn_loop
from tests.until import async_until

from wax.hooks.outbox import Message
from wax.hooks.post import HookError, _is_own, post, session

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

MESSAGE = Message("msg_1", "queue.empty", b'{"type":"queue.empty"}', 0.0)
LIMIT_S = 60.0
"""A test that needs the timeout turns the event loop's clock."""


@pytest.fixture
async def receiver() -> AsyncIterator[Receiver]:
    async with receiving() as made:
        yield made


async def _post(url: str, *, own_port: int = 0, wants_answer: bool = False) -> tuple[int, bytes]:
    async with session(lambda: own_port) as http:
        return await post(
            http,
            url,
            MESSAGE,
            secret=bytes(24),
            unix_s=1_700_000_000,
            limit_s=LIMIT_S,
            wants_answer=wants_answer,
        )


async def test_an_event_is_posted_and_signed(receiver: Receiver) -> None:
    """One request carries the signed body; any 2xx accepts it."""
    receiver.status = 202
    assert await _post(receiver.url) == (202, b"")
    [(path, headers, body)] = receiver.asked
    assert (path, body) == ("/secret-path", MESSAGE.body)
    assert headers["Content-Type"] == "application/json"
    assert headers["User-Agent"].startswith("WAX/")
    assert (headers["webhook-id"], headers["webhook-timestamp"]) == ("msg_1", "1700000000")
    assert headers["webhook-signature"].startswith("v1,")


@pytest.mark.parametrize(
    "path", ["/h?sig=AbC%2Fd%2Be%3D&&x=", "/tok%7Een%2Dx", "/a%28b%29/../c?q=a+b%20c", "/?x=%C3%BC"]
)
async def test_an_address_is_sent_as_it_is_written(receiver: Receiver, path: str) -> None:
    """The URL is sent byte for byte: decoding and encoding would break a signed one."""
    await _post(f"http://127.0.0.1:{receiver.port}{path}")
    assert [asked for asked, *_ in receiver.asked] == [path]


async def test_a_connection_keeps_the_systems_receive_buffer(
    receiver: Receiver, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A smaller buffer takes many round trips for a receiver's certificates; the limit is 10 s."""
    sizes_bytes: list[int] = []
    made = ResponseHandler.connection_made

    def noted(handler: ResponseHandler, transport: asyncio.BaseTransport) -> None:
        line = transport.get_extra_info("socket")
        sizes_bytes.append(line.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF))
        made(handler, transport)

    monkeypatch.setattr(ResponseHandler, "connection_made", noted)
    await _post(receiver.url)
    with socket.create_connection(("127.0.0.1", receiver.port)) as plain:
        assert sizes_bytes == [plain.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF)]


@pytest.mark.parametrize("status", [301, 302, 303, 307, 308])
async def test_no_redirect_is_followed(receiver: Receiver, status: int) -> None:
    """A redirect is a failure whose sentence says what to configure instead."""
    receiver.status = status
    with pytest.raises(HookError, match=rf"redirects with status {status}, .* \[\[hook\]\] url"):
        await _post(receiver.url)
    assert [path for path, *_ in receiver.asked] == ["/secret-path"]


@pytest.mark.parametrize("status", [400, 404, 429, 500, 503])
async def test_a_refusal_is_told_by_its_status(receiver: Receiver, status: int) -> None:
    """The sentence has the status and none of the answer's text, which a stranger wrote."""
    receiver.status, receiver.text = status, "look at me"
    with pytest.raises(HookError) as refused:
        await _post(receiver.url)
    assert str(refused.value) == f"It answers with status {status}."


async def test_one_that_never_answers_costs_the_time_limit(
    receiver: Receiver, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After the timeout the connection is closed, at the receiver's end too."""
    receiver.does = "hangs"
    posting = asyncio.create_task(_post(receiver.url))
    await asyncio.wait_for(receiver.arrived.get(), 5)
    turn_loop(LIMIT_S, monkeypatch)
    with pytest.raises(HookError, match=r"does not answer within 60 s"):
        await posting
    await asyncio.wait_for(receiver.ended.wait(), 5)


@pytest.mark.parametrize("wants_answer", [False, True])
async def test_an_endless_answer_is_not_read(receiver: Receiver, wants_answer: bool) -> None:
    """A receiver can send no more than the kernels buffer, and the event counts as accepted."""
    receiver.does, receiver.status = "floods", 200
    status, begins = await _post(receiver.url, wants_answer=wants_answer)
    assert status == 200
    assert len(begins) <= 2048
    assert bool(begins) == wants_answer
    await asyncio.wait_for(receiver.ended.wait(), 5)
    assert receiver.sent_bytes < 50_000_000


@pytest.mark.parametrize("wants_answer", [False, True])
async def test_an_answer_that_drips_holds_nobody_up(receiver: Receiver, wants_answer: bool) -> None:
    """The status alone counts: a body that drips delays nothing."""
    receiver.does, receiver.status = "drips", 200
    status, begins = await _post(receiver.url, wants_answer=wants_answer)
    assert status == 200
    assert len(begins) < 80


async def test_nobody_there_is_a_sentence() -> None:
    """If the connection is refused, the sentence says so."""
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        port = taken.getsockname()[1]
        with pytest.raises(HookError, match=r"Nobody listens at .* \(connection refused\)"):
            await _post(f"http://127.0.0.1:{port}/")


@asynccontextmanager
async def _babbling(said: bytes) -> AsyncIterator[str]:
    """Yield the URL of a server that sends `said` again and again, whatever it is asked."""
    ended = asyncio.Event()

    async def babble(_: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        with suppress(ConnectionError):
            while True:
                writer.write(said)
                await writer.drain()  # which waits only once all buffers are full
                await asyncio.sleep(0)
        writer.close()
        ended.set()

    server = await asyncio.start_server(babble, "127.0.0.1", 0)
    async with server:
        yield f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}/secret-path"
        await asyncio.wait_for(ended.wait(), 5)


@pytest.mark.parametrize("said", [b"SSH-2.0-" + b"x" * 5000 + b"\r\n\r\n", b"HTTP/1.1 200 \0\r\n"])
async def test_what_is_no_http_is_a_sentence(said: bytes) -> None:
    """The sentence shows neither the answer's text nor the path of the URL."""
    async with _babbling(said) as url:
        with pytest.raises(HookError) as refused:
            await _post(url)
    assert refused.value.sentence.code == "unreachable.no_http"
    assert "secret-path" not in str(refused.value)
    assert "SSH" not in str(refused.value)


async def test_of_announcements_without_end_a_few_are_parsed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Interim responses without end are parsed up to 8,192 bytes: driving waits for the parser."""
    came_bytes: list[int] = []
    taken = ResponseHandler.data_received

    def noted(handler: ResponseHandler, data: bytes) -> None:
        came_bytes.append(len(data))
        taken(handler, data)

    monkeypatch.setattr(ResponseHandler, "data_received", noted)
    async with _babbling(b"HTTP/1.1 100 Continue\r\n\r\n" * 4000) as url:
        posting = asyncio.create_task(_post(url))
        await async_until(lambda: sum(came_bytes) == 8192)
        turn_loop(LIMIT_S, monkeypatch)
        with pytest.raises(HookError, match="does not answer"):
            await posting
    assert sum(came_bytes) == 8192


@pytest.mark.parametrize("host", ["127.0.0.1", "0.0.0.0", "robot.example"])
async def test_the_servers_own_port_is_never_reached(
    receiver: Receiver, host: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An address of this machine, or a name that resolves to one, never leads to our own port."""
    real = socket.getaddrinfo

    def look_up(name: str, *more: object) -> object:
        return real("127.0.0.1" if name == "robot.example" else name, *more)  # type: ignore[arg-type]

    monkeypatch.setattr(socket, "getaddrinfo", look_up)
    with pytest.raises(HookError, match=r"cannot be reached: .*this server itself"):
        await _post(f"http://{host}:{receiver.port}/", own_port=receiver.port)
    assert receiver.asked == []


def test_the_same_port_of_another_machine_is_another_program() -> None:
    """An address for documentation (RFC 5737) is not this machine's."""
    assert not _is_own(socket.AF_INET, "192.0.2.1")


async def test_a_name_is_looked_up_apart_from_the_event_loop(
    receiver: Receiver, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A name server that hangs uses no thread of the loop's executor, and times out."""
    real, asked, go_on = socket.getaddrinfo, threading.Event(), threading.Event()
    loop = asyncio.get_running_loop()

    def hang(name: str, *more: object) -> object:
        asked.set()
        go_on.wait(5)
        return real("127.0.0.1", *more)  # type: ignore[arg-type]

    monkeypatch.setattr(socket, "getaddrinfo", hang)
    posting = asyncio.create_task(_post(f"http://robot.example:{receiver.port}/"))
    await async_until(asked.is_set)
    turn_loop(LIMIT_S, monkeypatch)
    with pytest.raises(HookError, match="does not answer within"):
        await posting
    assert loop._default_executor is None  # type: ignore[attr-defined]
    go_on.set()
    for one in threading.enumerate():
        if one.name.startswith("hook "):
            one.join(5)


async def test_a_name_is_found(receiver: Receiver) -> None:
    """A URL by name works, as with `localhost`."""
    assert await _post(f"http://localhost:{receiver.port}/") == (204, b"")


@pytest.mark.parametrize("name", [f"{'x' * 64}.invalid", "exam\u00adple.org", "a..b"])
async def test_what_can_be_no_name_is_a_sentence(name: str) -> None:
    """The sentence for an impossible host name does not show the path of the URL."""
    with pytest.raises(HookError) as refused:
        await _post(f"http://{name}/secret-path")
    assert str(refused.value) == "It cannot be reached: such a name cannot exist."


@pytest.mark.parametrize("plain", [None, b"HTTP/1.1 400 Bad Request\r\nContent-Length: 0\r\n\r\n"])
async def test_a_receiver_that_expects_tls_is_a_sentence(
    tmp_path: Path, plain: bytes | None
) -> None:
    """A TLS receiver asked by http:// is recognized whether it hangs up or answers 400."""
    with (
        serving(server_context(pair(tmp_path)), plain=plain) as port,
        pytest.raises(HookError, match="write https:// in its address"),
    ):
        await _post(f"http://localhost:{port}/secret-path")
