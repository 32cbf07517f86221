"""LiveKit as a peer: its tokens, its configuration, and refusals as sentences."""

from __future__ import annotations

from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any, cast

import jwt
import pytest
from aiohttp import web

from e2e.harness.server import free_port
from e2e.peers.livekit.by_whip import publish
from e2e.peers.livekit.errors import LiveKitError
from e2e.peers.livekit.installation import find_server
from e2e.peers.livekit.page import Pages
from e2e.peers.livekit.server import Ports, environment, settings
from e2e.peers.livekit.tokens import Key, publisher_token, viewer_token

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

KEY = Key.make()


def claims(token: str) -> dict[str, Any]:
    return jwt.decode(token, KEY.secret, algorithms=["HS256"], issuer=KEY.name)


def test_a_publisher_may_only_publish_and_a_viewer_only_watch() -> None:
    """Both in the same room; the key's secret has the 32 characters that LiveKit requires."""
    robot, viewer = claims(publisher_token(KEY, "robot")), claims(viewer_token(KEY, "viewer-1"))
    assert len(KEY.secret) >= 32
    assert robot["sub"] == "robot"
    assert robot["video"]["room"] == viewer["video"]["room"]
    assert (robot["video"]["canPublish"], robot["video"]["canSubscribe"]) == (True, False)
    assert (viewer["video"]["canPublish"], viewer["video"]["canSubscribe"]) == (False, True)


def test_livekit_stays_on_its_address_and_asks_nobody() -> None:
    """It offers one address, looks for no other by STUN, and gets its secret in no argument."""
    found = settings("10.77.0.1", Ports(), KEY)
    assert found["bind_addresses"] == ["10.77.0.1"]
    assert found["rtc"]["ips"] == {"includes": ["10.77.0.1/32"]}
    assert found["rtc"]["node_ip"] == "10.77.0.1"
    assert found["rtc"]["use_external_ip"] is False
    assert found["rtc"]["enable_loopback_candidate"] is False
    assert KEY.secret in environment(found)["LIVEKIT_CONFIG"]


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


def test_a_wrong_path_of_the_server_is_named(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """A variable that names no program is told by its name and value."""
    monkeypatch.setenv("WAX_LIVEKIT", str(tmp_path))
    with pytest.raises(LiveKitError, match=f"WAX_LIVEKIT names no program: {tmp_path}"):
        find_server()


@asynccontextmanager
async def whip_server(status: int, text: str) -> AsyncIterator[str]:
    """Answer every offer alike; gives the server's address."""

    async def answer(request: web.Request) -> web.Response:
        return web.Response(status=status, text=text, content_type="application/sdp")

    app = web.Application()
    app.router.add_post("/whip/v1", answer)
    runner = web.AppRunner(app)
    await runner.setup()
    port = free_port()
    await web.TCPSite(runner, "127.0.0.1", port).start()
    try:
        yield f"http://127.0.0.1:{port}"
    finally:
        await runner.cleanup()


@pytest.mark.parametrize(
    ("status", "text", "said"),
    [
        (401, "no permission", r"answered 401: no permission"),
        (201, "this is no SDP", r"an answer that cannot be used"),
    ],
)
async def test_a_refusal_is_a_sentence(status: int, text: str, said: str) -> None:
    """What is refused, and what is no answer, are told apart; nobody there is named."""
    source = cast("Any", None)  # nothing is read before there is an answer
    async with whip_server(status, text) as url:
        with pytest.raises(LiveKitError, match=said):
            await publish(url, "token", source, source, lambda: None)
    with pytest.raises(LiveKitError, match=f"{url}/whip/v1 is not reached"):
        await publish(url, "token", source, source, lambda: None)
