"""The calls to LiveKit's API, and the tokens as LiveKit decodes them."""

from __future__ import annotations

import base64
from typing import TYPE_CHECKING, Any

import aiohttp
import jwt
import pytest
from aiohttp import web

from wax.cluster.errors import RoomError
from wax.cluster.livekit import TOPIC, LiveKitRoom

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

KEY, SECRET = "APIkey", "a secret of thirty-two characters"
NOW_S = 1_900_000_000


def claims_of(token: str) -> dict[str, Any]:
    """Return a token's claims with its signature verified, by the test's clock."""
    return jwt.decode(
        token, SECRET, algorithms=["HS256"], options={"verify_exp": False, "verify_nbf": False}
    )


class Twirp:
    """A server that records requests and answers as a test tells it to."""

    def __init__(self) -> None:
        self.asked: list[tuple[str, dict[str, Any], dict[str, Any]]] = []
        self.answer: tuple[int, str] = (200, "{}")
        self.health: tuple[int, str] = (200, "OK")

    async def tell_health(self, _request: web.Request) -> web.Response:
        status, text = self.health
        return web.Response(status=status, text=text)

    async def handle(self, request: web.Request) -> web.Response:
        token = request.headers["Authorization"].removeprefix("Bearer ")
        grants = claims_of(token)
        self.asked.append((request.match_info["method"], await request.json(), grants))
        status, text = self.answer
        return web.Response(status=status, text=text, content_type="application/json")


@pytest.fixture
async def twirp() -> AsyncIterator[tuple[Twirp, LiveKitRoom]]:
    server = Twirp()
    application = web.Application()
    application.router.add_get("/", server.tell_health)
    application.router.add_post("/twirp/livekit.RoomService/{method}", server.handle)
    runner = web.AppRunner(application)
    await runner.setup()
    site = web.TCPSite(runner, "127.0.0.1", 0)
    await site.start()
    _, port = runner.addresses[0]
    async with aiohttp.ClientSession() as http:
        yield (
            server,
            LiveKitRoom(
                http=lambda: http,
                url=f"ws://127.0.0.1:{port}",
                name="robot-1",
                api_key=KEY,
                api_secret=SECRET,
                wall_s=lambda: NOW_S,
            ),
        )
    await runner.cleanup()


async def test_a_room_is_made_with_one_clock_and_room_to_wait_for_the_sound(
    twirp: tuple[Twirp, LiveKitRoom],
) -> None:
    """The room synchronizes sound and picture, and lets pages hold pictures back for them."""
    server, room = twirp
    await room.create()
    ((method, body, grants),) = server.asked
    assert method == "CreateRoom"
    assert (body["name"], body["sync_streams"], body["max_playout_delay"]) == ("robot-1", True, 200)
    assert grants["video"]["roomCreate"] is True


async def test_a_node_that_counts_as_dead_is_not_asked_for_its_room(
    twirp: tuple[Twirp, LiveKitRoom],
) -> None:
    """A node that reports 406 is not asked for its room; a proxy's 404 does not count."""
    server, room = twirp
    server.health = (406, "Not Ready")
    with pytest.raises(RoomError, match="is not ready yet"):
        await room.create()
    assert server.asked == []
    server.health = (404, "Not Found")
    await room.create()
    assert len(server.asked) == 1


async def test_everybody_is_told_and_counted(twirp: tuple[Twirp, LiveKitRoom]) -> None:
    """News is sent in base64, and a room that does not exist counts as empty."""
    server, room = twirp
    assert await room.count() == 0
    server.answer = (200, '{"rooms": [{"name": "robot-1", "num_participants": 7}]}')
    assert await room.count() == 7
    server.answer = (200, "{}")
    await room.send('{"type": "room"}')
    await room.remove("p-1")
    (_, told, _), (_, removed, _) = server.asked[2:]
    assert base64.b64decode(told["data"]) == b'{"type": "room"}'
    assert (told["room"], told["topic"]) == ("robot-1", TOPIC)
    assert removed == {"room": "robot-1", "identity": "p-1"}


@pytest.mark.parametrize(
    ("answer", "why"),
    [
        ((401, '{"code": "unauthenticated", "msg": "invalid token"}'), "invalid token"),
        ((503, "{}"), "Service Unavailable"),
        ((200, "no JSON"), "does not answer"),
        ((200, '{"rooms": 7}'), "does not answer CreateRoom as LiveKit does"),
        ((200, '{"a": [' + "[]," * 5000 + "[]]}"), "more values"),
        ((200, " " * 20_000), "answers with more than 16384 bytes"),
    ],
)
async def test_what_livekit_refuses_is_a_sentence(
    twirp: tuple[Twirp, LiveKitRoom], answer: tuple[int, str], why: str
) -> None:
    """A refusal's sentence has LiveKit's own reason, if it gives one."""
    server, room = twirp
    server.answer = answer
    with pytest.raises(RoomError, match=why):
        await room.create()


async def test_a_livekit_that_is_not_there_is_a_sentence() -> None:
    """A refused connection is a sentence with LiveKit's address."""
    async with aiohttp.ClientSession() as http:
        room = LiveKitRoom(
            http=lambda: http,
            url="ws://127.0.0.1:9",
            name="robot-1",
            api_key=KEY,
            api_secret=SECRET,
            wall_s=lambda: NOW_S,
        )
        with pytest.raises(RoomError, match=r"127\.0\.0\.1:9 does not answer"):
            await room.create()


def test_a_token_lets_one_person_watch_one_room_for_five_minutes() -> None:
    """A watch token lets one person watch one room for 5 min, hidden and unable to publish."""
    room = LiveKitRoom(
        http=aiohttp.ClientSession,
        url="wss://livekit.example.org",
        name="robot-1",
        api_key=KEY,
        api_secret=SECRET,
        wall_s=lambda: NOW_S,
    )
    claims = claims_of(room.watch_token("p-1"))
    assert (claims["iss"], claims["sub"], claims["exp"]) == (KEY, "p-1", NOW_S + 300)
    assert claims["video"] == {
        "room": "robot-1",
        "roomJoin": True,
        "canPublishData": False,
        "canPublish": False,
        "canSubscribe": True,
        "hidden": True,
    }
    claims = claims_of(room.publish_token("robot"))
    assert (claims["video"]["canPublish"], claims["video"]["canSubscribe"]) == (True, False)
    assert room.whip_url == "https://livekit.example.org/whip/v1"
