"""A tab that is hidden as a person does it; the browser informs the page.

Playwright tells each of its own pages that it is in front and in focus, whatever is. This tab is
beside them in the same browser, over the Chrome DevTools Protocol alone.
"""

from __future__ import annotations

import asyncio
import itertools
import json
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from playwright.async_api import Browser, CDPSession

_ANSWER_S: Final = 10.0
_KEY_CODES: Final = {"ArrowUp": 38}


class Tab:
    """One tab of a headless Chromium, opened by `open`."""

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

    async def key(self, what: str, name: str) -> None:
        """Press a key (``keyDown``) or release it (``keyUp``)."""
        code = _KEY_CODES[name]
        await self._send(
            "Input.dispatchKeyEvent", type=what, key=name, code=name, windowsVirtualKeyCode=code
        )

    async def open_another(self) -> None:
        """Open another tab in front of this one."""
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
