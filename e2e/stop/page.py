"""A viewer in a Chromium of their own, which can be frozen, killed, and hidden by another tab."""

from __future__ import annotations

import asyncio
import itertools
import json
import os
import signal
from contextlib import asynccontextmanager, suppress
from typing import TYPE_CHECKING, Any, Final

import psutil
from playwright.async_api import Error as PlaywrightError
from playwright.async_api import async_playwright

from e2e.harness.chromium import launch_chromium
from e2e.harness.scripts import press, says
from e2e.harness.viewer import Viewer
from e2e.harness.wait import eventually

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable

    from playwright.async_api import Browser, CDPSession

    from e2e.harness.page_clock import PageClock

    Launch = Callable[[str], Awaitable["Chromium"]]

KEY: Final = "ArrowUp"
_CLOSE_S: Final = 3.0
_ANSWER_S: Final = 10.0


class Chromium:
    """One browser, one page, the key ahead."""

    def __init__(self, browser: Browser, pid: int, viewer: Viewer) -> None:
        self.viewer = viewer
        self._browser = browser
        self._pid = pid
        self._pids: list[int] = []

    async def press(self) -> None:
        """Release and press again, as required after every fault."""
        await self.viewer.page.keyboard.up(KEY)
        await asyncio.sleep(0.08)
        self.find()
        await self.viewer.page.keyboard.down(KEY)

    def freeze(self) -> None:
        """SIGSTOP to all of its processes, including the network's."""
        self._signal(signal.SIGSTOP)

    def thaw(self) -> None:
        self._signal(signal.SIGCONT)

    def kill(self) -> None:
        """SIGKILL to all of its processes."""
        self._signal(signal.SIGKILL)

    async def close(self) -> None:
        """Close whatever is left of it; safe after `freeze` and `kill`."""
        self.thaw()
        with suppress(PlaywrightError, TimeoutError):
            async with asyncio.timeout(_CLOSE_S):
                await self._browser.close()

    def find(self) -> None:
        """Find its processes before they are signalled, because that takes a while."""
        children = psutil.Process(self._pid).children(recursive=True)
        self._pids = [self._pid, *(child.pid for child in children)]

    def _signal(self, how: signal.Signals) -> None:
        for pid in self._pids:
            with suppress(ProcessLookupError):
                os.kill(pid, how)


@asynccontextmanager
async def chromiums() -> AsyncIterator[Launch]:
    """Yield a function that opens a page in a browser of its own; all are closed at the end."""
    opened: list[Chromium] = []
    async with async_playwright() as playwright:

        async def launch(url: str) -> Chromium:
            browser = await launch_chromium(playwright)
            session = await browser.new_browser_cdp_session()
            info = (await session.send("SystemInfo.getProcessInfo"))["processInfo"]
            pid = next(int(one["id"]) for one in info if one["type"] == "browser")
            viewer = await Viewer.at(await browser.new_context(), url)
            await viewer.sees_picture()
            opened.append(Chromium(browser, pid, viewer))
            return opened[-1]

        try:
            yield launch
        finally:
            for one in opened:
                await one.close()


class Tab:
    """A tab that is hidden as a person does it, and drives by a key that is held.

    Playwright tells each of its own pages that it is in front and in focus, whatever is. This one
    is beside them in the same browser, over the Chrome DevTools Protocol alone.
    """

    clock: PageClock

    def __init__(self, browser: CDPSession, session: str) -> None:
        self._browser = browser
        self._session = session
        self._other: str | None = None
        self._ids = itertools.count(1)
        self._asked: dict[int, asyncio.Future[dict[str, Any]]] = {}
        browser.on("Target.receivedMessageFromTarget", self._heard)

    @classmethod
    async def open(cls, browser: Browser, url: str, script: str) -> Tab:
        """Open a page in which `script` runs before its own."""
        session = await browser.new_browser_cdp_session()
        target = (await session.send("Target.createTarget", {"url": "about:blank"}))["targetId"]
        attached = await session.send("Target.attachToTarget", {"targetId": target})
        tab = cls(session, attached["sessionId"])
        await tab._send("Page.enable")
        await tab._send("Page.addScriptToEvaluateOnNewDocument", source=script)
        await tab._send("Page.navigate", url=url)
        return tab

    async def evaluate(self, expression: str) -> Any:
        """Return the value of a JavaScript expression in the page, which must be JSON."""
        answer = await self._send("Runtime.evaluate", expression=expression, returnByValue=True)
        assert "exceptionDetails" not in answer, f"{expression}: {answer['exceptionDetails']}"
        return answer["result"].get("value")

    async def drive(self) -> None:
        """Wait until the page drives; join if it has no turn."""

        async def drives() -> bool:
            await self.evaluate(press("Join the queue"))
            return bool(await self.evaluate(says("You are driving")))

        await eventually(drives, "the tab drives", within_s=20)

    async def press(self) -> None:
        await self.key("keyUp")
        await asyncio.sleep(0.08)
        await self.key("keyDown")

    async def key(self, what: str) -> None:
        """Press the key (``keyDown``) or release it (``keyUp``)."""
        await self._send(
            "Input.dispatchKeyEvent", type=what, key=KEY, code=KEY, windowsVirtualKeyCode=38
        )

    async def open_another(self) -> None:
        other = await self._browser.send("Target.createTarget", {"url": "about:blank"})
        self._other = other["targetId"]

    async def close_another(self) -> None:
        await self._browser.send("Target.closeTarget", {"targetId": self._other})

    async def _send(self, method: str, **params: Any) -> dict[str, Any]:
        number = next(self._ids)
        answered = self._asked[number] = asyncio.get_running_loop().create_future()
        message = json.dumps({"id": number, "method": method, "params": params})
        asked = {"sessionId": self._session, "message": message}
        await self._browser.send("Target.sendMessageToTarget", asked)
        answer = await asyncio.wait_for(answered, _ANSWER_S)
        assert "error" not in answer, f"{method}: {answer['error']}"
        result: dict[str, Any] = answer["result"]
        return result

    def _heard(self, event: dict[str, Any]) -> None:
        message = json.loads(event["message"])
        answered = self._asked.pop(message.get("id"), None)
        if answered is not None and not answered.done():
            answered.set_result(message)
