"""Runs `wax replay` until it is interrupted."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import secrets
import signal
from typing import TYPE_CHECKING, Final

from aiohttp import web

from wax.clock import SystemClock
from wax.commands.replay.library import Library
from wax.commands.replay.server import ReplayServer
from wax.config.server import ServerSettings
from wax.edge.binding import listen
from wax.errors import StartError
from wax.telemetry import configure_logs
from wax.web.guards import Guards

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from wax.config.log import LogSettings

_HOST: Final = "localhost"
"""A tape shows people, so only this machine, and whoever sees this terminal, can open the page."""
_SECRET_BYTES: Final = 16


def replay(path: Path, port: int, log: LogSettings, *, tell: Callable[[str], None]) -> int:
    """Serve until Ctrl-C; returns the exit status. Raises `StateError` or `StartError`."""
    library = Library(path)
    configure_logs(log)
    try:
        asyncio.run(_serve(library, port, tell))
    finally:
        library.close()
    return 0


async def _serve(library: Library, port: int, tell: Callable[[str], None]) -> None:
    guards = Guards(ServerSettings(host=_HOST), SystemClock())
    secret = secrets.token_urlsafe(_SECRET_BYTES)
    server = ReplayServer(library, guards, secret)
    runner = web.AppRunner(
        server.application(), access_log=None, shutdown_timeout=0.5, handle_signals=False
    )
    over = asyncio.Event()
    loop = asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM):
        with contextlib.suppress(NotImplementedError):  # Windows: Ctrl-C raises instead
            loop.add_signal_handler(number, over.set)
    await runner.setup()
    try:
        try:
            for one in listen(_HOST, port):
                await web.SockSite(runner, one).start()
        except (OSError, OverflowError) as error:
            used = isinstance(error, OSError) and error.errno == errno.EADDRINUSE
            why = "it is used by another program" if used else str(error)
            raise StartError(
                f"cannot listen on port {port}: {why}; choose another port with --port"
            ) from error
        listening = runner.addresses[0][1]
        tell(f"\n  The tape:  http://{_HOST}:{listening}/{secret}/\n\n  Ctrl-C ends it.\n")
        await over.wait()
    finally:
        await runner.cleanup()
