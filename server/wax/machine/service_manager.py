"""Notifies systemd that the server is ready, still runs, or is stopping.

The protocol is sd_notify(3): datagrams of ``NAME=value`` to the Unix socket that the environment
names. Without one, as in a terminal or a container, nothing is sent.
"""

from __future__ import annotations

import asyncio
import os
import socket
from typing import TYPE_CHECKING, Final

import structlog

if TYPE_CHECKING:
    from collections.abc import MutableMapping

_LOG = structlog.get_logger(__name__)

_BEATS: Final = 3
"""Keepalives for each watchdog period, so that one may be late."""


class ServiceManager:
    """The service manager that started this process, if there is one; no method raises.

    Its variables are removed from `environment`: they are not meant for child processes.
    """

    def __init__(self, environment: MutableMapping[str, str]) -> None:
        self._address = environment.pop("NOTIFY_SOCKET", None)
        watchdog_us = environment.pop("WATCHDOG_USEC", "")
        is_ours = environment.pop("WATCHDOG_PID", None) in (None, str(os.getpid()))
        self._watchdog_s: float | None = None
        if self._address and is_ours and watchdog_us.isdecimal() and int(watchdog_us) > 0:
            self._watchdog_s = int(watchdog_us) / 1e6

    def ready(self) -> None:
        """Report that the page can be opened."""
        self._notify("READY=1")

    def stopping(self) -> None:
        """Report that the server is about to end."""
        self._notify("STOPPING=1")

    async def run(self) -> None:
        """Report that the event loop runs, often enough for the watchdog, until cancelled."""
        if self._watchdog_s is None:
            await asyncio.get_running_loop().create_future()
            return
        while True:
            self._notify("WATCHDOG=1")
            await asyncio.sleep(self._watchdog_s / _BEATS)

    def _notify(self, state: str) -> None:
        if not self._address:
            return
        # "@" stands for the zero byte that begins an abstract address (unix(7)).
        address = self._address
        name = b"\0" + os.fsencode(address[1:]) if address[0] == "@" else os.fsencode(address)
        try:
            with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as line:
                line.setblocking(False)
                line.sendto(state.encode(), name)
        except OSError as error:
            _LOG.warning("the service manager cannot be told", state=state, error=str(error))
