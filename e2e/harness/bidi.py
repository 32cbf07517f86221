"""Enough of WebDriver BiDi (w3.org) to drive stock Firefox, over one websocket."""

from __future__ import annotations

import asyncio
import itertools
import json
import re
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any

import aiohttp

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from collections.abc import AsyncIterator
    from pathlib import Path

PREFERENCES = {
    "media.autoplay.default": 0,
    "media.autoplay.blocking_policy": 0,
    "media.peerconnection.ice.obfuscate_host_addresses": False,
    "media.peerconnection.ice.loopback": True,
    "media.gmp-manager.updateEnabled": False,
    "app.update.enabled": False,
    "app.normandy.enabled": False,
    "browser.shell.checkDefaultBrowser": False,
    "browser.startup.homepage_override.mstone": "ignore",
    "datareporting.policy.dataSubmissionEnabled": False,
    "toolkit.telemetry.reportingpolicy.firstRun": False,
    "network.captive-portal-service.enabled": False,
    "network.connectivity-service.enabled": False,
    "remote.active-protocols": 1,
}
START_WITHIN_S = 40


class Firefox:
    """One window; `evaluate` runs an expression in its page, `keys` are pressed by the browser."""

    def __init__(self, socket: aiohttp.ClientWebSocketResponse) -> None:
        self._socket = socket
        self._ids = itertools.count(1)
        self._context = ""

    async def begin(self, preload: str) -> None:
        """Open the session; `preload` runs before each page's own script."""
        await self.send("session.new", capabilities={})
        tree = await self.send("browsingContext.getTree")
        self._context = tree["contexts"][0]["context"]
        await self.send("script.addPreloadScript", functionDeclaration=f"() => {{ {preload} }}")

    async def goto(self, url: str) -> None:
        await self.send("browsingContext.navigate", context=self._context, url=url, wait="complete")

    async def evaluate(self, expression: str) -> Any:
        """Value of the (awaited) expression, by way of JSON; raises `AssertionError`."""
        done = await self.send(
            "script.evaluate",
            expression=f"(async () => JSON.stringify(await ({expression})))()",
            target={"context": self._context},
            awaitPromise=True,
            userActivation=True,
        )
        assert done["type"] == "success", done
        value = done["result"].get("value")
        return None if value is None else json.loads(value)

    async def key(self, kind: str, value: str) -> None:
        """`kind` is ``keyDown`` or ``keyUp``; `value` as in WebDriver's table of keys."""
        action = {"type": kind, "value": value}
        source = {"type": "key", "id": "keyboard", "actions": [action]}
        await self.send("input.performActions", context=self._context, actions=[source])

    async def send(self, method: str, **params: Any) -> Any:
        """One command and its result; raises `AssertionError` with the browser's own words."""
        number = next(self._ids)
        await self._socket.send_json({"id": number, "method": method, "params": params})
        while True:
            answer = await self._socket.receive_json(timeout=30)
            if answer.get("id") == number:
                assert answer["type"] == "success", f"{method}: {answer}"
                return answer["result"]


@asynccontextmanager
async def firefox(path: str, profile: Path, preload: str) -> AsyncIterator[Firefox]:
    """Start a headless Firefox with a fresh profile; it ends at the end of the block."""
    lines = [f"user_pref({json.dumps(k)}, {json.dumps(v)});" for k, v in PREFERENCES.items()]
    (profile / "user.js").write_text("\n".join(lines) + "\n", encoding="utf-8")
    process = await asyncio.create_subprocess_exec(
        path,
        *["--headless", "--no-remote", "--profile", str(profile), "--remote-debugging-port", "0"],
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.DEVNULL,
        stderr=asyncio.subprocess.PIPE,
    )
    drain: asyncio.Task[None] | None = None
    try:
        url = await asyncio.wait_for(_address(process), START_WITHIN_S)
        drain = asyncio.create_task(_drain(process))
        async with (
            aiohttp.ClientSession() as http,
            http.ws_connect(f"{url}/session", max_msg_size=0) as socket,
        ):
            window = Firefox(socket)
            await window.begin(preload)
            yield window
    finally:
        if process.returncode is None:
            process.terminate()
        await process.wait()
        if drain is not None:
            await drain


async def _address(process: Process) -> str:
    assert process.stderr is not None
    seen = b""
    async for line in process.stderr:
        found = re.search(rb"WebDriver BiDi listening on (ws://\S+)", line)
        if found:
            return found.group(1).decode()
        seen += line
    raise AssertionError(f"Firefox ended at start: {seen.decode(errors='replace')}")


async def _drain(process: Process) -> None:
    """Read what it says on, since a full pipe would stop it."""
    assert process.stderr is not None
    async for _ in process.stderr:
        pass
