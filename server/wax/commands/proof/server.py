"""The server under proof: a process that can be frozen and killed."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import socket
import sys
from typing import TYPE_CHECKING, Any, Final

import aiohttp

from wax.client.host import become_host
from wax.commands.proof.controlled_process import ControlledProcess
from wax.errors import StartError, StateError

if TYPE_CHECKING:
    from pathlib import Path

_START_S: Final = 30.0
_LOOK_S: Final = 0.1
_STATUS_S: Final = 2.0


class ServerUnderProof(ControlledProcess):
    """A server whose configuration and log are in `folder`."""

    def __init__(self, folder: Path, configuration: str) -> None:
        super().__init__(folder / "server.log")
        self.url = ""
        self._config = folder / "wax.toml"
        self._config.write_text(configuration, encoding="utf-8")
        self._state = folder / "state"
        self._cookies: aiohttp.CookieJar | None = None

    async def start(self) -> None:
        """Start it on a free port of the loopback interface; raises `StartError`."""
        self._cookies = None  # without records, what made it a host ended with the last server
        port = _free_port()
        self.url = f"http://127.0.0.1:{port}"
        command = [sys.executable, "-m", "wax", "--config", str(self._config)]
        command += ["--host", "127.0.0.1", "--port", str(port)]
        process = await self.spawn(*command, stdin=asyncio.subprocess.DEVNULL)
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(_START_S):
                while process.returncode is None:
                    if await self.robot() is not None:
                        return
                    await asyncio.sleep(_LOOK_S)
        raise StartError(f"the server under proof does not start: {self.last_line()}")

    async def robot(self) -> dict[str, Any] | None:
        """Return its status of the robot, None while it does not answer."""
        timeout = aiohttp.ClientTimeout(total=_STATUS_S)
        if self._cookies is None:
            self._cookies = aiohttp.CookieJar(unsafe=True)  # its host is an address
        try:
            async with aiohttp.ClientSession(timeout=timeout, cookie_jar=self._cookies) as http:
                if not len(self._cookies):
                    await become_host(http, self.url, self._state)
                response = await http.get(f"{self.url}/api/status")
                response.raise_for_status()
                robot: dict[str, Any] = (await response.json())["robot"]
                return robot
        except (aiohttp.ClientError, TimeoutError, StateError):
            return None

    async def driver_pid(self) -> int:
        """Return the process id of the driver process; raises `StartError` if it is unknown."""
        pid = (await self.robot() or {}).get("driver_pid")
        if pid is None:
            raise StartError("the server does not report its driver process.")
        return int(pid)


def kill(pid: int) -> None:
    """Kill a process that may already have ended."""
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
