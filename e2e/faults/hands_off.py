"""Whatever takes the operator's hands off the page, zero is on the wire before he notices."""

from __future__ import annotations

import asyncio
import time
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from e2e.faults.page import chromiums
from e2e.faults.stage import random_phase, staged
from e2e.faults.trials import repeat, told
from e2e.harness.hands import Fingers

if TYPE_CHECKING:
    from collections.abc import Mapping

    from playwright.async_api import Page

    from e2e.faults.page import Chromium
    from e2e.faults.record import Stopping
    from e2e.faults.stage import Stage
    from e2e.measure.row import Row

GOAL_MS: Final = 120.0
_LOOK_S: Final = 0.25

EVENTS: Final = {
    "blur": "window.dispatchEvent(new Event('blur'));",
    "hidden": """
        Object.defineProperty(document, "visibilityState", { value: "hidden", configurable: true });
        Object.defineProperty(document, "hidden", { value: true, configurable: true });
        document.dispatchEvent(new Event("visibilitychange"));
    """,
    "pagehide": "window.dispatchEvent(new Event('pagehide'));",
}
"""What the browser tells a page; headless Chromium keeps every tab in front and in focus, so that
these events have to be made. A cancelled touch is the browser's own (`Fingers.cancel`)."""

_PATIENT: Final = {"turns": {"grace_s": 5.0}}
"""A page that was hidden for good has closed its connection; it comes back to its own turn."""

_SHOW: Final = """() => {
    delete document.visibilityState;
    delete document.hidden;
    document.dispatchEvent(new Event("visibilitychange"));
    window.dispatchEvent(new PageTransitionEvent("pageshow", { persisted: true }));
    window.dispatchEvent(new Event("focus"));
}"""


async def hands_off(
    n: int,
    *,
    events: Mapping[str, str] = EVENTS,
    script: str = "",
    **settings: Any,
) -> list[Row]:
    """From the event to the first frame that stops; `n` times each, and for a cancelled touch.

    `script` runs in the page before its own.
    """

    async def prepare(page: Page) -> None:
        await page.add_init_script(script)

    async with staged(_PATIENT, **settings) as stage, chromiums() as launch:
        page = await launch(stage.server.url, prepare=prepare, has_touch=True)
        await page.take_the_wheel()
        hands = _Hands(stage, page, await Fingers.of(page.viewer))
        found = {
            name: await repeat(f"hands-off: {name}", n, partial(hands.by_event, script))
            for name, script in events.items()
        }
        found["pointercancel"] = await repeat("hands-off: pointercancel", n, hands.by_touch)
    return [
        told(f"hands-off: {name}", f"{name} in the page → zero on the wire", trials, GOAL_MS)
        for name, trials in found.items()
    ]


class _Hands:
    """One trial each."""

    def __init__(self, stage: Stage, page: Chromium, fingers: Fingers) -> None:
        self._stage = stage
        self._page = page
        self._fingers = fingers
        self._is_down = False

    async def by_event(self, script: str) -> Stopping | None:
        browser = self._page.viewer.page
        await self._stage.moving(self._page.press)
        await random_phase()
        at_ms = await browser.evaluate(
            f"() => {{ const at_ms = performance.now(); {script} return at_ms; }}"
        )
        await asyncio.sleep(_LOOK_S)
        since_s = await self._page.monotonic_s(at_ms)
        found = self._found(since_s)
        await browser.evaluate(_SHOW)
        await self._page.let_go()
        await self._page.viewer.drives()
        return found

    async def by_touch(self) -> Stopping | None:
        await self._stage.moving(self._touch)
        await random_phase()
        since_s = time.monotonic()
        await self._fingers.cancel()
        self._is_down = False
        await asyncio.sleep(_LOOK_S)
        return self._found(since_s)

    async def _touch(self) -> None:
        if self._is_down:
            await self._fingers.lift(0)
        await asyncio.sleep(0.08)
        self._is_down = True
        await self._fingers.press(0, self._page.viewer.button("Forward"))

    def _found(self, since_s: float) -> Stopping | None:
        return self._stage.outcome(since_s)
