"""Firefox at the browser end, driven over WebDriver BiDi through a relay."""

from __future__ import annotations

import asyncio
import json
import os
from contextlib import AsyncExitStack, asynccontextmanager, contextmanager, suppress
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import urlsplit

import aiohttp

from e2e.browsers.window import LOAD_WITHIN_S
from e2e.delay.relay import http_through
from e2e.harness import bidi
from e2e.measure.errors import MeasureError

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from collections.abc import AsyncIterator, Iterator, Sequence
    from pathlib import Path

    from e2e.browsers.window import Key
    from e2e.link import Link
    from e2e.measure.ear import Ear

END_WITHIN_S: Final = 5.0
KEYS: Final[dict[Key, str]] = {"ArrowUp": "\ue013", "KeyT": "t"}
"""WebDriver's table of keys."""

# The pages' own policies rightly refuse an instrument's scripts, and Firefox has neither a command
# nor any more a preference to set them aside. An extension may.
MANIFEST: Final = {
    "manifest_version": 2,
    "name": "Without content security policy",
    "version": "1",
    "browser_specific_settings": {"gecko": {"id": "lab@wax.invalid"}},
    "permissions": ["declarativeNetRequest", "<all_urls>"],
    "declarative_net_request": {
        "rule_resources": [{"id": "policy", "enabled": True, "path": "rules.json"}]
    },
}
RULES: Final = [
    {
        "id": 1,
        "condition": {"resourceTypes": ["main_frame"]},
        "action": {
            "type": "modifyHeaders",
            "responseHeaders": [{"header": "Content-Security-Policy", "operation": "remove"}],
        },
    }
]


class FirefoxWindow:
    def __init__(self, window: bidi.Firefox) -> None:
        self._window = window

    async def goto(self, url: str) -> None:
        with _failing(f"{url} does not open in Firefox"):
            await self._window.goto(url, within_s=LOAD_WITHIN_S)

    async def evaluate(self, expression: str) -> Any:
        with _failing("a script failed in Firefox"):
            return await self._window.evaluate(expression)

    async def hold(self, key: Key) -> None:
        with _failing(f"{key} cannot be pressed in Firefox"):
            await self._window.key("keyDown", KEYS[key])

    async def release(self, key: Key) -> None:
        with _failing(f"{key} cannot be let go of in Firefox"):
            await self._window.key("keyUp", KEYS[key])


class FirefoxBrowser:
    def __init__(self, session: bidi.Session, ear: Ear) -> None:
        self._session = session
        self.ear = ear

    async def cpu_s(self) -> float | None:
        return None

    @asynccontextmanager
    async def window(self, preload: str) -> AsyncIterator[FirefoxWindow]:
        send = self._session.send
        with _failing("Firefox opens no window"):
            user = (await send("browser.createUserContext"))["userContext"]
            # A window and not a tab: only one tab of a window is visible.
            opened = await send("browsingContext.create", type="window", userContext=user)
            await send(
                "script.addPreloadScript",
                functionDeclaration=f"() => {{ {preload} }}",
                contexts=[opened["context"]],
            )
        try:
            yield FirefoxWindow(bidi.Firefox(self._session, opened["context"]))
        finally:
            with suppress(AssertionError):  # a browser that has ended has no windows either
                await send("browser.removeUserContext", userContext=user)


@contextmanager
def _failing(what: str) -> Iterator[None]:
    """Let the driver's error be one sentence."""
    try:
        yield
    except AssertionError as error:
        raise MeasureError(f"{what}: {error}") from error


@asynccontextmanager
async def open_firefox(
    path: str, link: Link, origins: Sequence[str], folder: Path, ear: Ear
) -> AsyncIterator[FirefoxBrowser]:
    """Start it headless; see `e2e.browsers.open_browser`."""
    profile, extension = folder / "profile", folder / "extension"
    for made in (profile, extension):
        made.mkdir()
    (extension / "manifest.json").write_text(json.dumps(MANIFEST), encoding="utf-8")
    (extension / "rules.json").write_text(json.dumps(RULES), encoding="utf-8")
    preferences = {
        **bidi.PREFERENCES,
        "dom.securecontext.allowlist": ",".join(str(urlsplit(one).hostname) for one in origins),
        "intl.accept_languages": "en-GB, en",
    }
    with (profile / bidi.LOG).open("wb") as log:
        process = await link.browser.spawn(
            [path, *bidi.arguments(profile, preferences)],
            stdin=asyncio.subprocess.DEVNULL,
            stdout=log,
            stderr=log,
            env={**os.environ, **ear.variables},
        )
    try:
        async with _talking(link, profile, process) as session:
            await session.send(
                "webExtension.install", extensionData={"type": "path", "path": str(extension)}
            )
            yield FirefoxBrowser(session, ear)
    finally:
        await _end(process)


@asynccontextmanager
async def _talking(link: Link, profile: Path, process: Process) -> AsyncIterator[bidi.Session]:
    try:
        url = await bidi.listens(profile, process)
    except AssertionError as error:
        raise MeasureError(str(error)) from error
    host, port = str(urlsplit(url).hostname), urlsplit(url).port or 0
    async with AsyncExitStack() as opened:
        http = await opened.enter_async_context(http_through(link.browser, host, port))
        try:
            session = await opened.enter_async_context(bidi.talking(http, url))
        except (AssertionError, aiohttp.ClientError) as error:
            raise MeasureError(f"Firefox does not answer: {error}") from error
        yield session


async def _end(process: Process) -> None:
    with suppress(ProcessLookupError):
        process.terminate()
    try:
        await asyncio.wait_for(process.wait(), END_WITHIN_S)
    except TimeoutError:
        process.kill()
        await process.wait()
