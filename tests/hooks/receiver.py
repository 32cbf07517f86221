"""A webhook receiver that behaves as a test tells it to."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, NoReturn

from aiohttp import web

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

SECRET = "whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw"


class Receiver:
    """Answers with `status`; `does` is ``answers``, ``floods``, ``drips`` or ``hangs``."""

    def __init__(self) -> None:
        self.asked: list[tuple[str, dict[str, str], bytes]] = []
        self.status = 204
        self.does = "answers"
        self.text = ""
        self.retry_after = ""
        self.sent_bytes = 0
        self.port = 0
        self.ended = asyncio.Event()
        self.arrived: asyncio.Queue[None] = asyncio.Queue()

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}/secret-path"

    async def handle(self, request: web.Request) -> web.StreamResponse:
        self.asked.append((request.raw_path, dict(request.headers), await request.read()))
        self.arrived.put_nowait(None)
        try:
            if self.does == "hangs":
                await asyncio.Event().wait()
            if self.does in ("floods", "drips"):
                await self._stream(request)
        finally:
            self.ended.set()
        location = {"Location": "/elsewhere"} if 300 <= self.status < 400 else {}
        later = {"Retry-After": self.retry_after} if self.retry_after else {}
        return web.Response(status=self.status, text=self.text or None, headers=location | later)

    async def _stream(self, request: web.Request) -> NoReturn:
        """Send until the client disconnects."""
        response = web.StreamResponse(status=self.status)
        await response.prepare(request)
        piece = b"x" * (65_536 if self.does == "floods" else 1)
        while True:
            await response.write(piece)
            self.sent_bytes += len(piece)
            if self.does == "drips":
                await asyncio.sleep(0.01)


@asynccontextmanager
async def receiving() -> AsyncIterator[Receiver]:
    made = Receiver()
    application = web.Application()
    application.router.add_route("*", "/{path:.*}", made.handle)
    runner = web.AppRunner(application, handler_cancellation=True, shutdown_timeout=0.1)
    await runner.setup()
    await web.TCPSite(runner, "127.0.0.1", 0).start()
    made.port = runner.addresses[0][1]
    try:
        yield made
    finally:
        await runner.cleanup()


def secret_file(folder: Path) -> str:
    """Return the path of a file with a secret."""
    path = folder / "hook-secret"
    path.write_text(SECRET)
    return str(path)
