"""The page that plays what LiveKit sends, and the server that delivers it."""

from __future__ import annotations

import asyncio
import gzip
import json
import secrets
from contextlib import asynccontextmanager
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Final

from aiohttp import web

from e2e.peers.livekit.tokens import in_room

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from e2e.peers.livekit.tokens import Key
    from e2e.peers.sizes import Size

_PAGE: Final = Path(__file__).with_name("page.html")
_STOP_WITHIN_S: Final = 1.0


@asynccontextmanager
async def pages(
    address: str,
    port: int,
    livekit_url: str,
    key: Key,
    script: bytes,
    *,
    size: Size,
    is_adaptive: bool,
) -> AsyncIterator[asyncio.Event]:
    """Serve inside the block; yield an event to set once it is published: until then no health.

    Everybody who opens the page gets an identity and a token of their own. `livekit_url` is the
    signalling's, such as ``ws://127.0.0.1:7880``; `script` is livekit-client; `size` is that of its
    video element, and `is_adaptive` whether it asks for the layer that fits.
    """
    template, published = Template(_PAGE.read_text(encoding="utf-8")), asyncio.Event()
    compressed = gzip.compress(script, mtime=0)

    async def give_page(request: web.Request) -> web.Response:
        token = in_room(key, f"viewer-{secrets.token_hex(6)}", publishes=False)
        place = {"url": livekit_url, "token": token, "adaptive": is_adaptive}
        page = template.substitute(place=json.dumps(place), width=size.width, height=size.height)
        response = web.Response(text=page, content_type="text/html")
        response.enable_compression()
        return response

    async def give_health(request: web.Request) -> web.Response:
        return web.Response(status=200 if published.is_set() else 503)

    async def give_script(request: web.Request) -> web.Response:
        headers = {"Content-Encoding": "gzip"}  # every browser accepts it
        return web.Response(body=compressed, content_type="text/javascript", headers=headers)

    app = web.Application()
    app.router.add_get("/", give_page)
    app.router.add_get("/livekit-client.umd.js", give_script)
    app.router.add_get("/healthz", give_health)
    runner = web.AppRunner(app, access_log=None, shutdown_timeout=_STOP_WITHIN_S)
    await runner.setup()
    try:
        await web.TCPSite(runner, address, port).start()
        yield published
    finally:
        await runner.cleanup()
