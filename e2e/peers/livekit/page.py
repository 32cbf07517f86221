"""The page that plays what LiveKit sends, and the server that delivers it."""

from __future__ import annotations

import gzip
import json
import secrets
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Final

from aiohttp import web

from e2e.peers.livekit.tokens import in_room

if TYPE_CHECKING:
    from e2e.peers.livekit.tokens import Key

_PAGE: Final = Path(__file__).with_name("page.html")
_STOP_WITHIN_S: Final = 1.0


class Pages:
    """Everybody who opens the page gets an identity and a token of their own with it.

    `livekit_url` is the signalling's, as ``ws://127.0.0.1:7880``; `script` is livekit-client;
    `is_adaptive` is whether the page asks for the layer that fits its video element.
    """

    published = False
    """Until then ``/healthz`` is a 503."""

    def __init__(
        self, livekit_url: str, key: Key, script: Path, *, is_adaptive: bool = True
    ) -> None:
        self._is_adaptive = is_adaptive
        self._livekit_url = livekit_url
        self._key = key
        self._page = Template(_PAGE.read_text(encoding="utf-8"))
        self._script = gzip.compress(script.read_bytes(), mtime=0)
        self._runner: web.AppRunner | None = None

    async def start(self, address: str, port: int) -> None:
        """Serve from now on."""
        app = web.Application()
        app.router.add_get("/", self._give_page)
        app.router.add_get("/livekit-client.umd.js", self._give_script)
        app.router.add_get("/healthz", self._give_health)
        self._runner = web.AppRunner(app, access_log=None, shutdown_timeout=_STOP_WITHIN_S)
        await self._runner.setup()
        await web.TCPSite(self._runner, address, port).start()

    async def stop(self) -> None:
        if self._runner is not None:
            await self._runner.cleanup()

    async def _give_page(self, request: web.Request) -> web.Response:
        """Make the page for one more viewer."""
        token = in_room(self._key, f"viewer-{secrets.token_hex(6)}", publishes=False)
        place = {"url": self._livekit_url, "token": token, "adaptive": self._is_adaptive}
        page = self._page.substitute(place=json.dumps(place))
        response = web.Response(text=page, content_type="text/html")
        response.enable_compression()
        return response

    async def _give_health(self, request: web.Request) -> web.Response:
        return web.Response(status=200 if self.published else 503)

    async def _give_script(self, request: web.Request) -> web.Response:
        compressed = {"Content-Encoding": "gzip"}  # every browser takes it
        return web.Response(body=self._script, content_type="text/javascript", headers=compressed)
