"""Serves `/metrics` on a port of its own, which is private unless the host opens it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aiohttp import web
from prometheus_client.exposition import CONTENT_TYPE_LATEST

from wax.edge.binding import listen, why_not
from wax.errors import StartError

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.config.metrics import MetricSettings


class MetricsListener:
    """Listens while it is open; `text` returns the metrics."""

    def __init__(self, settings: MetricSettings, text: Callable[[], bytes]) -> None:
        self._settings = settings
        self._text = text
        application = web.Application(client_max_size=1024)
        application.router.add_get("/metrics", self._metrics)
        self._runner = web.AppRunner(
            application,
            access_log=None,
            shutdown_timeout=0.5,
            handle_signals=False,
            keepalive_timeout=30.0,
        )

    async def open(self) -> int:
        """Listen; returns the port. Raises `StartError`."""
        host, port = self._settings.host, self._settings.port
        await self._runner.setup()
        try:
            for one in listen(host, port):
                # asyncio accepts up to `backlog` connections in one pass of the event loop.
                await web.SockSite(self._runner, one, backlog=4).start()
        except OSError as error:
            raise StartError(
                f"TCP port {port} of {host} cannot be used for metrics:"
                f" {why_not(error, '[metrics] port')}"
            ) from error
        return int(self._runner.addresses[0][1])

    async def close(self) -> None:
        """Stop listening; safe to call if it never did."""
        await self._runner.cleanup()

    async def _metrics(self, request: web.Request) -> web.Response:  # noqa: ARG002  # aiohttp's form
        return web.Response(body=self._text(), headers={"Content-Type": CONTENT_TYPE_LATEST})
