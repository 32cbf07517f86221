"""The part of WebDriver BiDi (w3.org) that drives stock Firefox, over one websocket."""

from __future__ import annotations

import asyncio
import itertools
import json
import os
from contextlib import asynccontextmanager, suppress
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

import aiohttp

from e2e.harness.child import terminate
from e2e.harness.installed import FIREFOX, installed
from e2e.harness.viewer import PROBE
from e2e.harness.wait import eventually

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from collections.abc import AsyncIterator, Mapping
    from pathlib import Path

    from e2e.measure.ear import Ear

PREFERENCES: Final[dict[str, bool | int | str]] = {
    "media.autoplay.default": 0,
    "media.autoplay.blocking_policy": 0,
    "media.peerconnection.ice.obfuscate_host_addresses": False,
    "media.peerconnection.ice.loopback": True,
    "media.navigator.permission.disabled": True,
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
LOG = "firefox.log"
START_WITHIN_S = 40
ANSWER_WITHIN_S = 30


class Session:
    """One websocket; one command at a time."""

    def __init__(self, socket: aiohttp.ClientWebSocketResponse) -> None:
        self._socket = socket
        self._ids = itertools.count(1)

    async def send(self, method: str, **params: Any) -> Any:
        """Send a command, return its result; raises `AssertionError` with the browser's message."""
        number, answer = next(self._ids), dict[str, Any]()
        try:
            async with asyncio.timeout(ANSWER_WITHIN_S):
                await self._socket.send_json({"id": number, "method": method, "params": params})
                while answer.get("id") != number:  # events, and answers that nobody awaited
                    answer = await self._socket.receive_json()
        except TimeoutError:
            raise AssertionError(f"{method}: no answer within {ANSWER_WITHIN_S} s") from None
        except (ConnectionError, TypeError) as error:  # aiohttp's error for a closed socket
            raise AssertionError(f"{method}: Firefox has ended: {error}") from None
        said = f"{answer.get('error')}, {answer.get('message')}"
        assert answer["type"] == "success", f"{method}: {said}"
        return answer["result"]


class Firefox:
    """One window; `evaluate` runs an expression in its page, `keys` are pressed by the browser."""

    def __init__(self, session: Session, context: str) -> None:
        self._session = session
        self._context = context

    async def goto(self, url: str) -> None:
        await self._session.send(
            "browsingContext.navigate", context=self._context, url=url, wait="complete"
        )

    async def frame(self) -> Firefox:
        """Return the first frame of the page, of whatever origin."""
        tree = await self._session.send("browsingContext.getTree", root=self._context)
        return Firefox(self._session, tree["contexts"][0]["children"][0]["context"])

    async def evaluate(self, expression: str) -> Any:
        """Return the (awaited) expression's value, through JSON; raises `AssertionError`."""
        done = await self._session.send(
            "script.evaluate",
            expression=f"(async () => JSON.stringify(await ({expression})))()",
            target={"context": self._context},
            awaitPromise=True,
            userActivation=True,
        )
        assert done["type"] == "success", done["exceptionDetails"]["text"]
        value = done["result"].get("value")
        return None if value is None else json.loads(value)

    async def key(self, kind: str, value: str) -> None:
        """`kind` is ``keyDown`` or ``keyUp``; `value` as in WebDriver's table of keys."""
        action = {"type": kind, "value": value}
        await self._perform({"type": "key", "id": "keyboard", "actions": [action]})

    async def _perform(self, source: Mapping[str, Any]) -> None:
        await self._session.send("input.performActions", context=self._context, actions=[source])

    async def touch(self, *actions: Mapping[str, Any]) -> None:
        """Move, press and lift a finger; `actions` as in WebDriver."""
        touch = {"type": "pointer", "id": "touch", "parameters": {"pointerType": "touch"}}
        await self._perform(touch | {"actions": [dict(action) for action in actions]})


@asynccontextmanager
async def firefox(
    folder: Path,
    ear: Ear | None = None,
    preferences: Mapping[str, bool | int | str] = MappingProxyType({}),
) -> AsyncIterator[Firefox]:
    """Start a headless Firefox with a fresh profile in `folder`; it ends with the block.

    `preferences` are set in addition to the usual ones. Raises `NotRunError`.
    """
    path = installed(*FIREFOX)
    profile = folder / "profile"
    profile.mkdir()
    wanted = {**PREFERENCES, **preferences}
    lines = [f"user_pref({json.dumps(k)}, {json.dumps(v)});" for k, v in wanted.items()]
    (profile / "user.js").write_text("\n".join(lines) + "\n", encoding="utf-8")
    with (profile / LOG).open("wb") as log:
        process = await asyncio.create_subprocess_exec(
            *(path, "--headless", "--no-remote", "--profile", str(profile)),
            *("--remote-debugging-port", "0"),
            stdin=asyncio.subprocess.DEVNULL,
            stdout=log,
            stderr=log,
            env=None if ear is None else {**os.environ, **ear.variables},
        )
    try:
        url = await _listens(profile, process)
        async with (
            aiohttp.ClientSession() as http,
            http.ws_connect(f"{url}/session", max_msg_size=0) as socket,
        ):
            session = Session(socket)
            await session.send("session.new", capabilities={})
            tree = await session.send("browsingContext.getTree")
            script = f"() => {{ {PROBE.read_text(encoding='utf-8')} }}"
            await session.send("script.addPreloadScript", functionDeclaration=script)
            yield Firefox(session, tree["contexts"][0]["context"])
    finally:
        await terminate(process)


async def _listens(profile: Path, process: Process) -> str:
    """Wait until it accepts connections and return its URL; its log is `LOG` in the profile."""
    found = profile / "WebDriverBiDiServer.json"

    async def url() -> str:
        with suppress(OSError, ValueError, KeyError):  # not there yet, or incomplete
            server = json.loads(found.read_text(encoding="utf-8"))
            return f"ws://{server['ws_host']}:{server['ws_port']}"
        log = (profile / LOG).read_text(encoding="utf-8", errors="replace")
        assert process.returncode is None, f"Firefox has ended ({process.returncode}): {log}"
        return ""

    return await eventually(url, "Firefox listens", within_s=START_WITHIN_S, every_s=0.05)
