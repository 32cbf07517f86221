"""The part of WebDriver (w3.org) that drives Debian's WebKitGTK, on an invisible screen."""

from __future__ import annotations

import asyncio
import os
import shutil
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import aiohttp
from tests.free_port import free_port

from e2e.harness.child import terminate
from e2e.harness.wait import answers, eventually
from e2e.measure.errors import NotRunError

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

MINI_BROWSERS: Final = (
    "/usr/lib/*/webkit2gtk-4.1/MiniBrowser",
    "/usr/libexec/webkit2gtk-*/MiniBrowser",
)
_SCREEN: Final = "1600x1200x24"
_START_S: Final = 30.0
_ANSWER: Final = aiohttp.ClientTimeout(total=60.0)
_INSTALL: Final = "install the packages webkit2gtk-driver and xvfb (Debian)"


class WebKit:
    """One window; all methods raise `AssertionError` with the browser's own words."""

    def __init__(self, http: aiohttp.ClientSession, session: str) -> None:
        self._http = http
        self._session = session

    async def goto(self, url: str) -> None:
        await self._post("url", url=url)

    async def evaluate(self, expression: str) -> Any:
        """Return the value of a JavaScript expression, which must be JSON."""
        return await self._post("execute/sync", script=f"return ({expression})", args=[])

    async def resize(self, width: int, height: int) -> None:
        """Resize the page to so many pixels, as far as the browser allows a window so narrow."""
        frame = await self.evaluate("[outerWidth - innerWidth, outerHeight - innerHeight]")
        await self._post("window/rect", width=width + frame[0], height=height + frame[1])

    async def _post(self, path: str, **body: Any) -> Any:
        url = f"/session/{self._session}/{path}"
        return await _asked(self._http, "POST", url, body)


async def _asked(http: aiohttp.ClientSession, method: str, path: str, body: Any = None) -> Any:
    async with http.request(method, path, json=body) as response:
        value = (await response.json(content_type=None))["value"]
        assert response.ok, f"{method} {path}: {value}"
        return value


def find_webkit() -> tuple[str, str, str]:
    """Return the paths of the driver, its browser and the screen. Raises `NotRunError`."""
    driver, screen = shutil.which("WebKitWebDriver"), shutil.which("Xvfb")
    found = [str(one) for glob in MINI_BROWSERS for one in Path("/").glob(glob.lstrip("/"))]
    if driver is None or screen is None or not found:
        raise NotRunError(f"no WebKitGTK found: {_INSTALL}")
    return driver, found[0], screen


@asynccontextmanager
async def webkit(folder: Path) -> AsyncIterator[WebKit]:
    """Open a window of a browser with a fresh profile; `folder` takes its log and its files."""
    driver, browser, screen = find_webkit()
    async with AsyncExitStack() as leaving:
        display = await leaving.enter_async_context(_display(screen))
        port = free_port()
        environment = {**os.environ, "DISPLAY": f":{display}", "HOME": str(folder)}
        with (folder / "webkit.log").open("wb") as log:
            process = await asyncio.create_subprocess_exec(
                *(driver, f"--port={port}"), env=environment, stdout=log, stderr=log
            )
        leaving.push_async_callback(terminate, process)
        url = f"http://127.0.0.1:{port}"
        await eventually(
            lambda: answers(f"{url}/status"), "WebKitWebDriver listens", within_s=_START_S
        )
        http = await leaving.enter_async_context(aiohttp.ClientSession(url, timeout=_ANSWER))
        options = {"binary": browser, "args": ["--automation"]}
        wanted = {"capabilities": {"alwaysMatch": {"webkitgtk:browserOptions": options}}}
        session = str((await _asked(http, "POST", "/session", wanted))["sessionId"])
        leaving.push_async_callback(_asked, http, "DELETE", f"/session/{session}")
        yield WebKit(http, session)


@asynccontextmanager
async def _display(program: str) -> AsyncIterator[int]:
    """Run a screen in memory; yield its number, which it chooses itself."""
    process = await asyncio.create_subprocess_exec(
        *(program, "-displayfd", "1", "-screen", "0", _SCREEN, "-nolisten", "tcp"),
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.DEVNULL,
    )
    try:
        assert process.stdout is not None
        said = await asyncio.wait_for(process.stdout.readline(), _START_S)
        yield int(said)
    finally:
        await terminate(process)
