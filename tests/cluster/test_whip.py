"""WHIP by RFC 9725: an offer, an answer, an end."""

from __future__ import annotations

from typing import TYPE_CHECKING

import aiohttp
import pytest
from aiohttp import web

from wax.cluster.errors import RoomError
from wax.cluster.whip import WhipSession

if TYPE_CHECKING:
    from collections.abc import AsyncIterator


class Endpoint:
    """A WHIP server that records requests; `location` is the address that it gives a session."""

    def __init__(self) -> None:
        self.asked: list[tuple[str, str, str, str]] = []
        self.status = 201
        self.answer = "v=0 answer"
        self.location: str | None = "/sessions/1%2F2?sig=A%2Fd%2Be%3D"
        self.url = ""

    async def handle(self, request: web.Request) -> web.Response:
        kind, token = request.content_type, request.headers.get("Authorization", "")
        self.asked.append((request.method, request.raw_path, kind, token))
        if request.method == "DELETE":
            return web.Response()
        headers = {} if self.location is None else {"Location": self.location}
        return web.Response(status=self.status, text=self.answer, headers=headers)


@pytest.fixture
async def endpoint() -> AsyncIterator[tuple[Endpoint, WhipSession]]:
    made = Endpoint()
    application = web.Application()
    application.router.add_route("*", "/{path:.*}", made.handle)
    runner = web.AppRunner(application)
    await runner.setup()
    await web.TCPSite(runner, "127.0.0.1", 0).start()
    _, port = runner.addresses[0]
    async with aiohttp.ClientSession() as http:
        url = f"http://127.0.0.1:{port}/whip/r%2F1%7E"
        yield made, WhipSession(http=lambda: http, url=url, token=lambda: "t0ken")
    await runner.cleanup()


async def test_an_offer_is_answered_and_ended_once(endpoint: tuple[Endpoint, WhipSession]) -> None:
    """The session is deleted once, at exactly the address that the server gave."""
    server, session = endpoint
    assert await session.offer("v=0 offer") == "v=0 answer"
    await session.end()
    await session.end()
    assert server.asked == [
        ("POST", "/whip/r%2F1%7E", "application/sdp", "Bearer t0ken"),
        ("DELETE", "/sessions/1%2F2?sig=A%2Fd%2Be%3D", "application/octet-stream", "Bearer t0ken"),
    ]


async def test_a_server_without_sessions_is_not_asked_to_end_one(
    endpoint: tuple[Endpoint, WhipSession],
) -> None:
    """Without a Location, nothing is deleted."""
    server, session = endpoint
    server.location = None
    await session.offer("v=0 offer")
    await session.end()
    assert len(server.asked) == 1


async def test_a_long_answer_comes_whole(endpoint: tuple[Endpoint, WhipSession]) -> None:
    """An answer in several pieces is read whole; an endless one is refused."""
    server, session = endpoint
    for size in (60_000, 65_536):
        server.answer = "v" * size
        assert await session.offer("v=0 offer") == server.answer
    server.answer = "v" * 65_537
    with pytest.raises(RoomError, match="more than 65536 bytes"):
        await session.offer("v=0 offer")


@pytest.mark.parametrize("status", [200, 401, 404, 503])
async def test_a_refusal_has_the_servers_reason(
    endpoint: tuple[Endpoint, WhipSession], status: int
) -> None:
    """Any status but 201 is a refusal with the server's reason."""
    server, session = endpoint
    server.status = status
    with pytest.raises(RoomError, match=rf"refuses to publish \({status}\): v=0 answer"):
        await session.offer("v=0 offer")
    await session.end()


async def test_a_server_that_is_gone_is_a_sentence() -> None:
    """An unreachable server is a sentence when publishing, and no error when ending."""
    async with aiohttp.ClientSession() as http:
        session = WhipSession(http=lambda: http, url="http://127.0.0.1:9/whip", token=str)
        with pytest.raises(RoomError, match="does not answer"):
            await session.offer("v=0 offer")
        session._resource = "http://127.0.0.1:9/whip/1"
        await session.end()
