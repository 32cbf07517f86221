"""Debian's WebKitGTK: without WebRTC it says so; with a mock connection the layout is right."""

from __future__ import annotations

import json
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import aiohttp
import pytest
from aiohttp import web
from aiohttp.test_utils import TestServer

from e2e.gallery.views import ACROSS, DESKTOP, UPRIGHT
from e2e.harness import toml
from e2e.harness.scripts import reads
from e2e.harness.webkit import webkit
from e2e.measure.suite import ROOT

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from e2e.conftest import Serve

pytestmark = [pytest.mark.full, pytest.mark.timeout(120)]

LAYOUT: Final = (Path(__file__).parent / "gallery/layout.js").read_text(encoding="utf-8")
WORDS: Final = ROOT / "web/src/words/en/later.json"
SIDEWAYS: Final = "document.documentElement.scrollWidth - document.documentElement.clientWidth"
SILENT_PEER: Final = """
class Never extends EventTarget {
  connectionState = "new"; iceGatheringState = "new"; readyState = "connecting";
  addTransceiver() { return { receiver: { track: null }, sender: {}, direction: "recvonly" }; }
  createDataChannel() { return new Never(); }
  createOffer() { return new Promise(() => {}); }
  getStats() { return Promise.resolve(new Map()); }
  close() {}
}
window.RTCPeerConnection ??= Never;
"""
"""A WebRTC that never connects, so that the browser lays out the page all the same."""


async def test_what_is_missing_is_said(serve: Serve, tmp_path: Path) -> None:
    """Where there is no WebRTC the page says so, and what to do, in windows of all sizes."""
    async with serve(tmp_path, toml.CARD) as server, webkit(tmp_path) as window:
        await window.goto(server.url)
        assert not await window.evaluate("'RTCPeerConnection' in window"), "it has WebRTC now"
        words = json.loads(WORDS.read_text(encoding="utf-8"))
        for name in ("cannot", "no_webrtc", "switched_off", "what_to_do"):
            await reads(window, words[f"support.{name}"])
        for size in (UPRIGHT, ACROSS, DESKTOP):
            await window.resize(size.width, size.height)
            assert await window.evaluate(SIDEWAYS) <= 0, size.key


async def test_the_layout_is_whole(serve: Serve, tmp_path: Path) -> None:
    """The page of a browser that is still connecting fits all windows sideways."""
    async with (
        serve(tmp_path, toml.CARD) as server,
        _with_a_peer(server.url) as url,
        webkit(tmp_path) as window,
    ):
        await window.goto(url)
        await reads(window, "Connecting")
        for size in (UPRIGHT, ACROSS, DESKTOP):
            await window.resize(size.width, size.height)
            found = await window.evaluate(f"({LAYOUT})(null)")
            assert found == [], size.key


@asynccontextmanager
async def _with_a_peer(url: str) -> AsyncIterator[str]:
    """Forward the server's page, with `SILENT_PEER` before its own script; yield the address."""
    async with aiohttp.ClientSession() as http:

        async def passed_on(request: web.Request) -> web.Response:
            async with http.get(url + request.path) as response:
                body: Any = await response.read()
                kind = response.content_type
            if request.path == "/":
                script = b'<script src="/silent-peer.js"></script>'
                body = body.replace(b"<head>", b"<head>" + script, 1)
            return web.Response(body=body, content_type=kind)

        async def peer(_request: web.Request) -> web.Response:
            return web.Response(text=SILENT_PEER, content_type="text/javascript")

        application = web.Application()
        application.router.add_get("/silent-peer.js", peer)
        application.router.add_get("/{path:.*}", passed_on)
        async with TestServer(application) as passing:
            yield str(passing.make_url("/"))
