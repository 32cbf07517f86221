"""From outside: a page, a certificate and a viewer, against a real server."""

from __future__ import annotations

import asyncio
import datetime
import re
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any

import aiohttp
import pytest
from aiohttp import web
from aiohttp.test_utils import TestServer
from tests.commands.doctor.certificates import write_pair
from tests.deploy.running import answers, serving
from tests.free_port import free_port

from wax.client import client
from wax.commands.doctor import ports, reach
from wax.commands.doctor.network import network_of
from wax.config.settings import Settings

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from wax.web.certificate import Certificate

pytestmark = pytest.mark.system


@asynccontextmanager
async def _wax(folder: Path, video: str = "testcard") -> AsyncIterator[str]:
    config = folder / "wax.toml"
    config.write_text(f'[video]\nsource = "{video}"\n[audio]\nsource = "none"\n')
    port = free_port()
    async with serving(config, port) as process:
        await answers(port, process)
        yield f"http://127.0.0.1:{port}"


@asynccontextmanager
async def _tcp_only(url: str) -> AsyncIterator[str]:
    """Act as a router that forwards only TCP to a server."""

    async def offer(request: web.Request) -> web.Response:
        asked: dict[str, Any] = await request.json()
        asked["sdp"] = re.sub(r"a=candidate:[^\r\n]*\r?\n", "", asked["sdp"])
        async with (
            aiohttp.ClientSession() as http,
            http.post(f"{url}/api/offer", json=asked) as answer,
        ):
            sdp = (await answer.json())["sdp"]
        return web.json_response({"sdp": re.sub(r"a=candidate:[^\r\n]*\r?\n", "", sdp)})

    application = web.Application()
    application.router.add_post("/api/offer", offer)
    async with TestServer(application) as server:
        yield f"http://127.0.0.1:{server.port}"


async def test_a_server_is_within_reach_or_the_port_to_forward_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A reachable server is ok; without UDP, the port to forward is named; HTTP is a warning."""
    async with _wax(tmp_path) as url:
        page, safe, viewer = await asyncio.gather(
            *(
                asyncio.to_thread(look, url)
                for look in (reach.page, reach.certificate, reach.viewer)
            )
        )
        server = {"host": "127.0.0.1", "port": int(url.rpartition(":")[2])}
        ours = network_of(Settings.model_validate({"server": server}))
        assert await asyncio.to_thread(ports.is_running, ours)
        monkeypatch.setattr(client, "_CONNECT_S", 1.0)
        async with _tcp_only(url) as outside:
            cut = await asyncio.to_thread(reach.viewer, outside)
    assert (page.level, safe.level) == ("ok", "warning")
    assert (viewer.level, "gets the picture" in viewer.sentence) == ("ok", True), viewer
    assert (cut.level, "UDP port" in cut.advice) == ("bad", True), cut


async def test_a_camera_without_pictures_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A viewer that connects but gets no picture is reported."""
    monkeypatch.setattr(reach, "_PICTURE_S", 0.3)
    async with _wax(tmp_path, video="none") as url:
        verdict = await asyncio.to_thread(reach.viewer, url)
    assert (verdict.level, "no picture" in verdict.sentence) == ("warning", True), verdict


def test_a_page_below_a_path_is_looked_for_there() -> None:
    """A page below a path is checked there, not at the root."""
    assert reach.checked_url("https://example.org/robot/") == "https://example.org/robot"
    assert reach.checked_url("example.org") == "https://example.org"


async def test_what_is_no_server_of_ours_is_told() -> None:
    """A closed port, an unknown name, a proxy's error and a foreign page are told apart."""
    for look in (reach.page, reach.viewer):
        nobody = await asyncio.to_thread(look, f"http://127.0.0.1:{free_port()}")
        assert (nobody.level, "Nobody listens" in nobody.sentence) == ("bad", True), nobody
    nameless = await asyncio.to_thread(reach.page, "https://no.such.host.invalid")
    assert (nameless.level, "The name no.such.host.invalid" in nameless.sentence) == ("bad", True)

    async def hello(_: web.Request) -> web.Response:
        return web.Response(text="hello")

    application = web.Application()
    application.router.add_get("/", hello)
    application.router.add_post("/greets/api/offer", hello)
    async with TestServer(application) as server:
        other = await asyncio.to_thread(reach.page, f"http://127.0.0.1:{server.port}")
        missing = await asyncio.to_thread(reach.page, f"http://127.0.0.1:{server.port}/none")
        refused = await asyncio.to_thread(reach.viewer, f"http://127.0.0.1:{server.port}")
        greeted = await asyncio.to_thread(reach.viewer, f"http://127.0.0.1:{server.port}/greets")
    assert (other.level, missing.level, refused.level) == ("warning", "bad", "bad")
    assert (greeted.level, "not one of WAX" in greeted.sentence) == ("bad", True)
    assert "404" in missing.sentence


@asynccontextmanager
async def _secure(pair: Certificate) -> AsyncIterator[str]:
    """Serve a page by HTTPS with this certificate; yield its URL."""

    async def page(_: web.Request) -> web.Response:
        return web.Response(text="WAX")

    application = web.Application()
    application.router.add_get("/", page)
    server = TestServer(application, scheme="https")
    await server.start_server(ssl=pair.context())
    try:
        yield f"https://127.0.0.1:{server.port}"
    finally:
        await server.close()


async def test_a_certificate_is_seen_as_a_browser_sees_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An untrusted certificate is bad; a trusted one is ok, or a warning near its end."""
    now = datetime.datetime.now(datetime.UTC)
    for days, level in ((60, "ok"), (5, "warning")):
        ends = now + datetime.timedelta(days=days)
        pair = write_pair(tmp_path, "127.0.0.1", begins=now, ends=ends)
        async with _secure(pair) as url:
            monkeypatch.delenv("SSL_CERT_FILE", raising=False)
            untrusted = await asyncio.to_thread(reach.page, url)
            assert (untrusted.level, "not by an authority" in untrusted.sentence) == ("bad", True)
            shown = await asyncio.to_thread(reach.certificate, url)
            assert (shown.level, pair.fingerprint() in shown.sentence) == ("bad", True)
            monkeypatch.setenv("SSL_CERT_FILE", str(pair.chain))
            assert (await asyncio.to_thread(reach.page, url)).level == "ok"
            assert (await asyncio.to_thread(reach.certificate, url)).level == level
        unanswered = await asyncio.to_thread(reach.certificate, url)
        assert (unanswered.level, "No certificate" in unanswered.sentence) == ("bad", True)
