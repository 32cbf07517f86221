"""The server under proof: a process of its own that can be frozen and killed."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import socket
import sys
from typing import TYPE_CHECKING, Any, Final

import aiohttp

from wax.errors import StartError

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from pathlib import Path

_START_S: Final = 30.0
_END_S: Final = 3.0
_LOOK_S: Final = 0.1
_STATUS_S: Final = 2.0


class ServerUnderProof:
    """`folder` takes its configuration and its log."""

    def __init__(self, folder: Path, configuration: str) -> None:
        self.url = ""
        self._log = folder / "server.log"
        self._config = folder / "wax.toml"
        self._config.write_text(configuration, encoding="utf-8")
        self._process: Process | None = None

    async def start(self) -> None:
        """Start it on a free port of the loopback interface; raises `StartError`."""
        port = _free_port()
        self.url = f"http://127.0.0.1:{port}"
        command = [sys.executable, "-m", "wax", "--config", str(self._config)]
        with self._log.open("ab") as log:
            self._process = await asyncio.create_subprocess_exec(
                *(*command, "--host", "127.0.0.1", "--port", str(port)),
                stdin=asyncio.subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                start_new_session=True,  # Ctrl-C is for the proof, which ends it in its order
            )
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(_START_S):
                while self._process.returncode is None:
                    if await self.robot() is not None:
                        return
                    await asyncio.sleep(_LOOK_S)
        raise StartError(f"the server under proof does not start: {self._last_line()}")

    async def robot(self) -> dict[str, Any] | None:
        """Return its account of the robot, None while it does not answer."""
        timeout = aiohttp.ClientTimeout(total=_STATUS_S)
        try:
            async with (
                aiohttp.ClientSession(timeout=timeout) as http,
                http.get(f"{self.url}/api/status") as response,
            ):
                response.raise_for_status()
                robot: dict[str, Any] = (await response.json())["robot"]
                return robot
        except (aiohttp.ClientError, TimeoutError):
            return None

    def freeze(self) -> None:
        """Stop this process alone: the one that speaks with the robot goes on."""
        self._signal(signal.SIGSTOP)

    def thaw(self) -> None:
        self._signal(signal.SIGCONT)

    async def kill(self) -> None:
        self._signal(signal.SIGKILL)
        if self._process is not None:
            await self._process.wait()

    async def driver_pid(self) -> int | None:
        """Return which process speaks with the robot; None where it is the server itself."""
        pid = (await self.robot() or {}).get("driver_pid")
        return None if pid is None else int(pid)

    async def end(self) -> None:
        """End it, frozen or not; safe to call twice."""
        if self._process is None or self._process.returncode is not None:
            return
        self.thaw()
        self._signal(signal.SIGTERM)
        try:
            await asyncio.wait_for(self._process.wait(), _END_S)
        except TimeoutError:
            await self.kill()

    def _signal(self, number: signal.Signals) -> None:
        if self._process is not None:
            with contextlib.suppress(ProcessLookupError):
                self._process.send_signal(number)

    def _last_line(self) -> str:
        said = self._log.read_text(encoding="utf-8", errors="replace").strip()
        return said.rpartition("\n")[2] or "it said nothing"


def kill(pid: int) -> None:
    """Kill a process that may have ended by itself."""
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
