"""LiveKit as a peer: tokens, configuration, refusals, and what a browser sees and gets of it."""

from __future__ import annotations

import asyncio
import signal
import socket
import sys
from asyncio.subprocess import PIPE
from contextlib import asynccontextmanager
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import aiohttp
import jwt
import psutil  # type: ignore[import-untyped]  # its stubs are not among the dev tools
import pytest
from aiohttp import web
from aiortc import AudioStreamTrack

from e2e.harness.server import free_port
from e2e.harness.viewer import Viewer
from e2e.harness.wait import eventually
from e2e.peers.livekit import installation
from e2e.peers.livekit.__main__ import first_published, start_publisher, stop_publisher
from e2e.peers.livekit.errors import LiveKitError
from e2e.peers.livekit.installation import find_client, find_server
from e2e.peers.livekit.messages import FIRST_LINE, PUBLISHER_LINE, Published, Ready, Refusal
from e2e.peers.livekit.page import Pages
from e2e.peers.livekit.publisher import key_from
from e2e.peers.livekit.server import LiveKit, Ports, environment, settings
from e2e.peers.livekit.tokens import ROOM, Key, publisher_token, viewer_token
from e2e.peers.livekit.whip import PublishError, RefusedError, published

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from collections.abc import AsyncIterator

    from playwright.async_api import Browser

ROOT = Path(__file__).parents[3]
KEY = Key("APItest", "s" * 32)


def claims(token: str) -> dict[str, Any]:
    return jwt.decode(token, KEY.secret, algorithms=["HS256"], issuer=KEY.name)


# --- tokens and configuration -------------------------------------------------------------


def test_a_publisher_may_only_publish() -> None:
    """The publisher's token is signed, names him, and lets him publish in the room, not watch."""
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
    """Keys are made anew, with the 32 characters of secret that LiveKit wants."""
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


def test_everybody_gets_a_token_of_his_own(tmp_path: Path) -> None:
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


def test_a_publisher_without_a_key_is_told() -> None:
    """Both variables of the key are asked for when one is missing."""
    with pytest.raises(LiveKitError, match="LIVEKIT_API_KEY and LIVEKIT_API_SECRET"):
        key_from({"LIVEKIT_API_KEY": "APItest"})


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


# --- the whole ----------------------------------------------------------------------------


@asynccontextmanager
async def started(**given: str) -> AsyncIterator[Process]:
    """Start it on free ports, but for those given; what is left of it at the end is killed."""
    names = ("--port", "--signal-port", "--media-tcp-port", "--media-udp-port")
    ports = {name: str(free_port()) for name in names}
    ports |= {f"--{name.replace('_', '-')}": port for name, port in given.items()}
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "e2e.peers.livekit", *chain.from_iterable(ports.items())),
        cwd=ROOT,
        stdout=PIPE,
    )
    try:
        yield process
    finally:
        if process.returncode is None:
            for child in psutil.Process(process.pid).children(recursive=True):
                child.kill()
            process.kill()
            await process.wait()


async def first_line(process: Process) -> Ready | Refusal:
    assert process.stdout is not None
    return FIRST_LINE.validate_json(await asyncio.wait_for(process.stdout.readline(), 40))


@pytest.fixture
def _livekit() -> None:
    """Say why where there is none: unlike a browser, it is not on every machine that tests."""
    try:
        find_server()
        find_client()
    except LiveKitError as error:
        pytest.skip(str(error))


async def test_what_is_no_livekit_is_one_sentence(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """A program that ends at once is told as that, with exit status 1."""
    program = tmp_path / "livekit-server"
    program.write_text("#!/bin/sh\nexit 3\n", encoding="utf-8")
    program.chmod(0o755)
    monkeypatch.setenv("WAX_LIVEKIT", str(program))
    async with started() as process:
        refusal = await first_line(process)
        assert isinstance(refusal, Refusal)
        assert refusal.refused.startswith("LiveKit ended at its start with status 3")
        assert await asyncio.wait_for(process.wait(), 10) == 1


@pytest.mark.usefixtures("_livekit")
async def test_a_port_that_is_taken_is_one_sentence() -> None:
    """Where the page cannot be served it says so, and LiveKit is ended again."""
    signal_port = free_port()
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        async with started(port=str(port), signal_port=str(signal_port)) as process:
            refusal = await first_line(process)
            assert isinstance(refusal, Refusal)
            assert f"127.0.0.1:{port}" in refusal.refused
            assert await asyncio.wait_for(process.wait(), 10) == 1
    with socket.socket() as probe:
        assert probe.connect_ex(("127.0.0.1", signal_port)) != 0


@pytest.mark.timeout(90)
@pytest.mark.usefixtures("_livekit")
async def test_the_publisher_comes_back() -> None:
    """A publisher that LiveKit puts out publishes anew, without being told."""
    ports = Ports(free_port(), free_port(), free_port())
    livekit = LiveKit(find_server(), "127.0.0.1", ports, KEY)
    await livekit.start()
    publisher = await start_publisher(livekit.url, KEY, None)
    try:
        assert await first_published(publisher) == 1
        await put_out(livekit.url, "robot")
        assert publisher.stdout is not None
        line = await asyncio.wait_for(publisher.stdout.readline(), 40)
        assert PUBLISHER_LINE.validate_json(line) == Published(times=2)
    finally:
        await stop_publisher(publisher)
        await livekit.stop()


async def put_out(url: str, who: str) -> None:
    """Remove a participant, as an administrator does."""
    may = {"iss": KEY.name, "exp": 2**31, "video": {"room": ROOM, "roomAdmin": True}}
    token = jwt.encode(may, KEY.secret, algorithm="HS256")
    async with (
        aiohttp.ClientSession(raise_for_status=True) as http,
        http.post(
            f"{url}/twirp/livekit.RoomService/RemoveParticipant",
            json={"room": ROOM, "identity": who},
            headers={"Authorization": f"Bearer {token}"},
        ),
    ):
        pass


@pytest.mark.timeout(90)
@pytest.mark.usefixtures("_livekit")
async def test_when_livekit_dies_the_rest_ends() -> None:
    """A LiveKit that is killed is told in one sentence, and nothing of this peer stays."""
    async with started() as process:
        assert isinstance(await first_line(process), Ready)
        family = psutil.Process(process.pid).children(recursive=True)
        next(child for child in family if child.name() == find_server().name).kill()
        refusal = await first_line(process)
        assert isinstance(refusal, Refusal)
        assert refusal.refused.startswith("LiveKit ended with status -9")
        assert await asyncio.wait_for(process.wait(), 10) == 1
        assert not [child for child in family if child.is_running()]


@pytest.mark.timeout(90)
@pytest.mark.usefixtures("_livekit")
async def test_a_browser_sees_and_hears_through_livekit(chromium: Browser) -> None:
    """The test card comes whole, and packets of sound with it; Ctrl-C leaves no process."""
    async with started() as process:
        ready = await first_line(process)
        assert isinstance(ready, Ready)
        family = psutil.Process(process.pid).children(recursive=True)
        assert len(family) == 2  # LiveKit and the publisher; the page is the parent's
        context = await chromium.new_context()
        try:
            viewer = await Viewer.prepare(context, ready.url)
            await viewer.page.goto(ready.url)
            await viewer.sees_picture()
            cards = await viewer.cards(20)
            assert sum(card.valid for card in cards) >= 18
            assert {(card.width, card.height) for card in cards} == {(640, 480)}
            assert len({card.stamp_ms for card in cards}) >= 18

            async def hears() -> bool:
                return await viewer.packets("audio") > 50

            await eventually(hears, "packets of sound arrive")
            assert await viewer.says_connected()
            assert viewer.errors == []
        finally:
            await context.close()
        process.send_signal(signal.SIGINT)
        assert await asyncio.wait_for(process.wait(), 10) == 0
        assert not [child for child in family if child.is_running()]
