"""LiveKit as a peer: its tokens, its configuration, and refusals as sentences."""

from __future__ import annotations

from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any

import aiohttp
import jwt
import pytest
from aiohttp import web
from aiortc import AudioStreamTrack

from e2e.harness.server import free_port
from e2e.peers.livekit import installation
from e2e.peers.livekit.errors import LiveKitError
from e2e.peers.livekit.installation import find_client, find_server
from e2e.peers.livekit.page import Pages
from e2e.peers.livekit.server import Ports, environment, settings
from e2e.peers.livekit.tokens import Key, publisher_token, viewer_token
from e2e.peers.livekit.whip import PublishError, RefusedError, published

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

KEY = Key("APItest", "s" * 32)


def claims(token: str) -> dict[str, Any]:
    return jwt.decode(token, KEY.secret, algorithms=["HS256"], issuer=KEY.name)


# --- tokens and configuration -------------------------------------------------------------


def test_a_publisher_may_only_publish() -> None:
    """The publisher's token is signed, names them, and lets them publish in the room, not watch."""
    found = claims(publisher_token(KEY, "robot"))
    assert found["sub"] == "robot"
    assert found["video"]["roomJoin"]
    assert found["video"]["canPublish"]
    assert not found["video"]["canSubscribe"]


def test_a_viewer_may_only_watch() -> None:
    """A viewer's token is for the publisher's room, to watch and not to publish."""
    found = claims(viewer_token(KEY, "viewer-1"))["video"]
    assert found["room"] == claims(publisher_token(KEY, "robot"))["video"]["room"]
    assert found["canSubscribe"]
    assert not found["canPublish"]


def test_each_key_is_another_and_long_enough() -> None:
    """Keys are new each time, with the 32 characters of secret that LiveKit requires."""
    first, second = Key.make(), Key.make()
    assert first.secret != second.secret
    assert len(first.secret) >= 32


def test_livekit_stays_on_its_address_and_asks_nobody() -> None:
    """It listens and offers one address only, and looks for no other by STUN."""
    found = settings("10.77.0.1", Ports(), KEY)
    assert found["bind_addresses"] == ["10.77.0.1"]
    assert found["rtc"]["ips"] == {"includes": ["10.77.0.1/32"]}
    assert found["rtc"]["node_ip"] == "10.77.0.1"
    assert found["rtc"]["use_external_ip"] is False
    assert found["rtc"]["enable_loopback_candidate"] is False
    assert settings("127.0.0.1", Ports(), KEY)["rtc"]["enable_loopback_candidate"] is True


def test_the_configuration_travels_in_the_environment() -> None:
    """LiveKit gets its configuration, with the secret in it, in a variable, not as an argument."""
    assert KEY.secret in environment(settings("127.0.0.1", Ports(), KEY))["LIVEKIT_CONFIG"]


def test_everybody_gets_a_token_of_their_own(tmp_path: Path) -> None:
    """Two who open the page have two identities, and neither gets the key's secret."""
    script = tmp_path / "client.js"
    script.write_text("// a script", encoding="utf-8")
    pages = Pages("ws://127.0.0.1:7880", KEY, script)
    first, second = pages.page(), pages.page()
    assert KEY.secret not in first
    assert identity(first) != identity(second)


def identity(page: str) -> str:
    token = page.split('"token": "')[1].split('"', maxsplit=1)[0]
    return str(claims(token)["sub"])


# --- refusals -----------------------------------------------------------------------------


def test_without_a_server_the_sentence_says_how_to_get_one(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Where nothing was built one sentence names what to install and what to type."""
    monkeypatch.delenv("WAX_LIVEKIT", raising=False)
    monkeypatch.setattr(installation, "_BUILT", tmp_path / "server")
    with pytest.raises(LiveKitError, match=r"install Go and type sh \.make/livekit\.sh"):
        find_server()


def test_a_wrong_path_of_the_server_is_named(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """A variable that names no program is told by its name and value."""
    monkeypatch.setenv("WAX_LIVEKIT", str(tmp_path))
    with pytest.raises(LiveKitError, match=f"WAX_LIVEKIT names no program: {tmp_path}"):
        find_server()


def test_without_the_client_the_sentence_says_how_to_get_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Where npm has not been one sentence names what to type."""
    monkeypatch.setattr(installation, "_PACKAGE", tmp_path)
    with pytest.raises(LiveKitError, match="type make check"):
        find_client()


@asynccontextmanager
async def whip_server(status: int, text: str) -> AsyncIterator[str]:
    """Answer every offer alike; gives the endpoint's address."""

    async def answer(request: web.Request) -> web.Response:
        return web.Response(status=status, text=text, content_type="application/sdp")

    app = web.Application()
    app.router.add_post("/whip/v1", answer)
    runner = web.AppRunner(app)
    await runner.setup()
    port = free_port()
    await web.TCPSite(runner, "127.0.0.1", port).start()
    try:
        yield f"http://127.0.0.1:{port}/whip/v1"
    finally:
        await runner.cleanup()


@pytest.mark.parametrize(
    ("status", "text", "kind", "said"),
    [
        (401, "no permission", RefusedError, r"answered 401: no permission"),
        (503, "busy", PublishError, r"answered 503: busy"),
        (201, "this is no SDP", PublishError, r"an answer that cannot be used"),
    ],
)
async def test_a_refusal_is_told_from_a_failure(
    status: int, text: str, kind: type[LiveKitError], said: str
) -> None:
    """What asking again cannot change is another error than what it may, each one sentence."""
    async with whip_server(status, text) as endpoint, aiohttp.ClientSession() as http:
        with pytest.raises(kind, match=said):
            async with published(http, endpoint, "token", [AudioStreamTrack()]):
                pass


async def test_nobody_there_is_a_failure() -> None:
    """Where nobody listens, the sentence names the address."""
    endpoint = f"http://127.0.0.1:{free_port()}/whip/v1"
    async with aiohttp.ClientSession() as http:
        with pytest.raises(PublishError, match=f"{endpoint} is not reached"):
            async with published(http, endpoint, "token", [AudioStreamTrack()]):
                pass
