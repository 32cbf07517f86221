"""A server as a process at the server's end: healthy inside the block, gone after it."""

from __future__ import annotations

import asyncio
import os
import time
from contextlib import asynccontextmanager, suppress
from typing import TYPE_CHECKING, Any, Final, TypeVar

import aiohttp

from e2e.delay.relay import http_through
from e2e.harness.child import ends
from e2e.measure.errors import MeasureError
from wax.client.host import become_host
from wax.errors import StateError

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from collections.abc import AsyncIterator, Mapping, Sequence
    from contextlib import AbstractAsyncContextManager
    from pathlib import Path

    from playwright.async_api import Page

    from e2e.link import End, Link

PORT: Final = 8080
"""Always free, because each link has its own network."""
_START_WITHIN_S: Final = 40.0
_STOP_WITHIN_S: Final = 5.0
STATE: Final = "state"
"""The servers' XDG_STATE_HOME within their folder."""
_ASK_EVERY_S: Final = 0.05
_ANSWER_WITHIN: Final = aiohttp.ClientTimeout(total=10.0)
S = TypeVar("S", bound="Served")


def origin(link: Link) -> str:
    return f"http://{link.server.address}:{PORT}"


class Served:
    """One server that answers HTTP; `url` is what the browser opens."""

    def __init__(
        self, name: str, process: Process, url: str, log: Path, http: aiohttp.ClientSession
    ) -> None:
        self.pid = process.pid
        """The server's process, which may have children."""
        self.url = url
        self._name = name
        self._process = process
        self._log = log
        self._http = http

    async def opened(self, window: Page) -> None:
        """Turn the open page's sound on, and for ``operator`` take the wheel, as a person does.

        Returns when the page says so; raises `MeasureError` if it does not.
        """

    async def fail_safe_s(self) -> float | None:
        """Return how long the thesis's policy was in its fail-safe mode; None without that policy.

        Raises `MeasureError` if the server has ended.
        """
        self.check()
        return None

    async def healthy(self) -> None:
        """Wait until it serves; raises `MeasureError` if it ends before that or takes too long."""
        until_s = time.monotonic() + _START_WITHIN_S
        while time.monotonic() < until_s and self._process.returncode is None:
            with suppress(aiohttp.ClientError, TimeoutError):
                async with self._get("/healthz"):
                    return
            await asyncio.sleep(_ASK_EVERY_S)
        raise self._wrong()

    async def status(self) -> dict[str, Any]:
        """Return a WAX server's status, asked for as its host; raises `MeasureError`."""
        try:
            async with self._get("/api/status") as response:
                told: dict[str, Any] = await response.json()
        except (aiohttp.ClientError, TimeoutError) as error:
            raise self._wrong(f" ({error})") from error
        return told

    async def become_host(self, state_folder: Path) -> None:
        """Sign in as the host of a WAX server for all later requests; raises `MeasureError`."""
        try:
            await become_host(self._http, self.url.rstrip("/"), state_folder)
        except (aiohttp.ClientError, TimeoutError, StateError) as error:
            raise self._wrong(f" its host ({error})") from error

    def check(self) -> None:
        """Raise `MeasureError` if it has ended."""
        if self._process.returncode is not None:
            raise self._wrong()

    def _get(self, path: str) -> AbstractAsyncContextManager[aiohttp.ClientResponse]:
        return self._http.get(self.url + path, timeout=_ANSWER_WITHIN, raise_for_status=True)

    def _wrong(self, more: str = "") -> MeasureError:
        code = self._process.returncode
        how = "does not answer" if code is None else f"ended with status {code}"
        lines = self._log.read_text(encoding="utf-8", errors="replace").split("\n")
        said = next((line.strip() for line in reversed(lines) if line.strip()), "nothing")
        log = f"its log ends with: {said} ({self._log})"
        return MeasureError(f"the {self._name} server {how}{more}; {log}")


@asynccontextmanager
async def serving(
    kind: type[S],
    name: str,
    end: End,
    folder: Path,
    arguments: Sequence[str],
    *,
    variables: Mapping[str, str] | None = None,
) -> AsyncIterator[S]:
    """Run this Python at an end, log into `folder`; stop it afterwards, and kill it if needed.

    `variables` are added to its environment. Raises `MeasureError` with the end of its log if it
    does not become healthy.
    """
    path = folder / f"{name}.log"
    with path.open("wb") as log:
        process = await end.spawn_python(
            arguments,
            stdin=asyncio.subprocess.DEVNULL,
            stdout=log,
            stderr=log,
            env={
                **os.environ,
                **(variables or {}),
                "XDG_STATE_HOME": str((folder / STATE).resolve()),
            },
        )
    try:
        async with http_through(end, end.address, PORT) as http:
            served = kind(name, process, f"http://{end.address}:{PORT}", path, http)
            await served.healthy()
            yield served
    finally:
        with suppress(ProcessLookupError):
            process.terminate()
        await ends(process, _STOP_WITHIN_S)
