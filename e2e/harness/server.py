"""A real server in a process of its own, started and stopped as a person does."""

from __future__ import annotations

import asyncio
import os
import re
import signal
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, TypeVar

import aiohttp
from tests.free_port import free_port

from e2e.harness import toml as configurations
from e2e.harness.child import kill
from e2e.harness.wait import answers, eventually
from e2e.measure.suite import ROOT
from wax.client.host import become_host
from wax.errors import StateError

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from collections.abc import Callable

    from playwright.async_api import BrowserContext

T = TypeVar("T")

COMMAND = Path(sys.executable).with_name("wax")
CLIENT_ID = re.compile(r"\b[0-9a-f]{8}(?:-[0-9a-f]{4}){3}-[0-9a-f]{12}\b(?!\.local)")
"""What a page sends so that it is recognised, in a page's own form; mDNS names look alike (RFC
8828)."""
ACCOUNT_WITHIN_S = 2.0


class Server:
    """`toml` is its configuration, besides those of `for_one_machine`; `folder` has it and the log.

    The log has both its outputs. Only a host may read its status, so this class is one, by the
    socket of `wax host-link`. As an async context manager it serves inside the block and stops
    cleanly afterwards.
    """

    def __init__(self, folder: Path, toml: str) -> None:
        self.port = free_port()
        self.url = f"http://127.0.0.1:{self.port}"
        self.log_path = folder / "server.log"
        self._config_path = folder / "wax.toml"
        self._config_path.write_text(configurations.for_one_machine(toml), encoding="utf-8")
        self.state_folder = folder / "state" / "wax"
        self._host: aiohttp.CookieJar | None = None
        self.environment: dict[str, str] = {
            "XDG_STATE_HOME": str(self.state_folder.parent),
            "PYTHONPATH": str(ROOT),
        }
        """Added to this process's environment; plug-ins of the tests are found by their names."""
        self.niceness = 0
        """The process's nice value; less than this process's own only where that is allowed."""
        self._process: Process | None = None

    async def __aenter__(self) -> Self:
        try:
            await self.start()
        except BaseException:
            await self.kill()
            raise
        return self

    async def __aexit__(self, kind: type[BaseException] | None, *_: object) -> None:
        try:
            if kind is None:
                await self.stop()
        finally:
            await self.kill()

    @property
    def log(self) -> str:
        if not self.log_path.exists():
            return ""
        return self.log_path.read_text(encoding="utf-8", errors="replace")

    def account(self) -> str:
        """Return the end of its log and its status, for the report of a failed test."""
        with ThreadPoolExecutor(1) as beside:  # the caller may be in an event loop
            status = beside.submit(asyncio.run, self._account()).result()
        return f"{self.log[-6000:]}\n{status}"

    async def _account(self) -> str:
        try:
            async with asyncio.timeout(ACCOUNT_WITHIN_S):
                _, status = await self.get("/api/status", await self.host_cookies())
        except (OSError, TimeoutError, aiohttp.ClientError, StateError) as error:
            return f"no status: {error!r}"
        return str(status)

    @property
    def pid(self) -> int:
        assert self._process is not None, "the server was not started"
        return self._process.pid

    async def launch(self) -> None:
        self._host = None
        arguments = ["--config", str(self._config_path)]
        arguments += ["--host", "127.0.0.1", "--port", str(self.port), "--udp-port", "0"]
        with self.log_path.open("ab") as log:
            self._process = await asyncio.create_subprocess_exec(
                str(COMMAND),
                *arguments,
                stdin=asyncio.subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                env=os.environ | self.environment,
            )
        if self.niceness:
            with suppress(PermissionError):
                os.setpriority(os.PRIO_PROCESS, self._process.pid, self.niceness)

    async def start(self) -> None:
        """Start the process and wait until it serves."""
        await self.launch()
        await eventually(self._serves_or_ended, "the server serves", within_s=40)
        code = self._process.returncode if self._process else None
        assert code is None, f"the server ended with {code} at start:\n{self.log}"

    async def stop(self, how: signal.Signals = signal.SIGTERM) -> None:
        """Ask it to exit; raises `AssertionError` if it hangs, fails or has logged an error.

        `tests.deploy` tests how soon it must exit.
        """
        if self._process is None or self._process.returncode is not None:
            return
        self._process.send_signal(how)
        try:
            code = await asyncio.wait_for(self._process.wait(), 20)
        except TimeoutError:
            await self.kill()
            raise AssertionError(f"still running 20 s after {how.name}") from None
        assert code == 0, f"exit status {code} after {how.name}"
        _, traceback, rest = self.log.partition("Traceback")
        assert not traceback, f"the server's log holds a traceback{rest[:6000]}"
        assert not CLIENT_ID.search(self.log), "the server's log holds what identifies a page"

    async def kill(self) -> None:
        """Kill it without a goodbye to its viewers."""
        await kill(self._process)

    async def get(self, path: str, cookies: aiohttp.CookieJar | None = None) -> tuple[int, Any]:
        """Return the HTTP status and the parsed JSON, or the text if it is not JSON.

        It asks as a stranger, or as the visitor with these cookies.
        """
        async with (
            aiohttp.ClientSession(cookie_jar=cookies) as http,
            http.get(self.url + path) as response,
        ):
            if response.content_type == "application/json":
                return response.status, await response.json()
            return response.status, await response.text()

    # --- the host ---------------------------------------------------------------------------

    async def host_cookies(self) -> aiohttp.CookieJar:
        """Return the cookies of a new host; raises `StateError` or `aiohttp.ClientError`."""
        jar = aiohttp.CookieJar(unsafe=True)  # the server is an address
        async with aiohttp.ClientSession(cookie_jar=jar) as http:
            await become_host(http, self.url, self.state_folder)
        return jar

    async def make_host(self, context: BrowserContext) -> None:
        kept: dict[str, Any] = {"url": self.url, "httpOnly": True, "sameSite": "Strict"}
        made = await self.host_cookies()
        cookies: Any = [{"name": one.key, "value": one.value, **kept} for one in made]
        await context.add_cookies(cookies)

    async def status(self) -> dict[str, Any]:
        """`GET /api/status`, as the host."""
        if self._host is None:
            self._host = await self.host_cookies()
        code, body = await self.get("/api/status", self._host)
        assert code == 200, f"/api/status says {code}: {body}"
        assert isinstance(body, dict)
        return body

    async def until(self, ask: Callable[[dict[str, Any]], T], what: str, **limits: float) -> T:
        """Wait as `eventually` does for an answer by its status."""

        async def answer() -> T:
            return ask(await self.status())

        return await eventually(answer, what, **limits)

    async def _serves_or_ended(self) -> bool:
        has_ended = self._process is not None and self._process.returncode is not None
        return has_ended or await answers(f"{self.url}/healthz")
