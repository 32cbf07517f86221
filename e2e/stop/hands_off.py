"""Whatever makes the operator lose the controls, a zero command is sent before they notice."""

from __future__ import annotations

import asyncio
import time
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from e2e.harness.page_clock import page_clock
from e2e.harness.tab import Tab
from e2e.harness.touch_screen import TouchPoints
from e2e.harness.wait import eventually
from e2e.measure.errors import MeasureError
from e2e.stop.page import KEY, chromiums
from e2e.stop.stage import random_phase, staged
from e2e.stop.trials import repeat, told

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Sequence

    from e2e.measure.row import Row
    from e2e.stop.page import Chromium
    from e2e.stop.record import Stopping
    from e2e.stop.stage import Stage

    Act = Callable[[Tab], Awaitable[None]]

GOAL_MS: Final = 120.0
_LOOK_S: Final = 0.25
_BACK_S: Final = 20.0

ACTS: Final[dict[str, tuple[Act, Act]]] = {
    "another tab": (Tab.open_another, Tab.close_another),
    "minimised window": (Tab.minimise, Tab.restore),
    "navigation": (Tab.leave, Tab.come_back),
}
"""What a person does, and how it is undone. The first two make the browser send blur and hidden,
the third beforeunload and pagehide."""

_NOTE: Final = """
for (const [target, type] of [
    [window, "blur"],
    [document, "visibilitychange"],
    [window, "beforeunload"],
    [window, "pagehide"],
]) target.addEventListener(type, () => { sessionStorage.waxLost ??= performance.now(); }, true);
"""
"""Notes when the page got its first event; the note outlives the page."""

_PATIENT: Final = {"turns": {"grace_s": 10.0}}
"""A page that was left has closed its connection; it returns to its own turn."""

_JOIN: Final = """
[...document.querySelectorAll("button")].find((one) => one.innerText === "Join the queue")?.click()
"""
_DRIVES: Final = "document.body.innerText.includes('You are driving')"


async def hands_off(
    n: int,
    *,
    acts: Sequence[str] = tuple(ACTS),
    script: str = "",
    **settings: Any,
) -> list[Row]:
    """Time from the event to the first stopping frame, `n` times each, and for a cancelled touch.

    `script` runs in the page before its own.
    """
    async with staged(_PATIENT, **settings) as stage, chromiums() as launch:
        page = await launch(stage.server.url, has_touch=True)
        browser = page.viewer.page.context.browser
        assert browser is not None
        tab = await Tab.open(browser, stage.server.url, _NOTE + script)
        held_key = _HeldKey(stage, tab)
        await held_key.drive()
        found = {
            name: await repeat(f"hands-off: {name}", n, partial(held_key.lose, *ACTS[name]))
            for name in acts
        }
        await tab.close()
        await page.take_the_wheel()
        await page.viewer.drive_by("Buttons")
        touch = _Touch(stage, page, await TouchPoints.of(page.viewer))
        found["pointercancel"] = await repeat("hands-off: pointercancel", n, touch.cancel)
    return [
        told(f"hands-off: {name}", f"{name}: first event in the page → zero", trials, GOAL_MS)
        for name, trials in found.items()
    ]


class _HeldKey:
    """Hold a key in a tab, and lose it."""

    def __init__(self, stage: Stage, tab: Tab) -> None:
        self._stage = stage
        self._tab = tab

    async def drive(self) -> None:
        """Wait until the page drives; join if it has no turn."""

        async def drives() -> bool:
            await self._tab.evaluate(_JOIN)
            return bool(await self._tab.evaluate(_DRIVES))

        await eventually(drives, "the tab drives", within_s=_BACK_S)

    async def lose(self, act: Act, undo: Act) -> Stopping | None:
        await self._stage.moving(self._press)
        clock = await page_clock(self._tab.evaluate)
        await self._tab.evaluate("delete sessionStorage.waxLost")
        await random_phase()
        await act(self._tab)
        await asyncio.sleep(_LOOK_S)
        until_s = time.monotonic()
        await undo(self._tab)
        lost_ms = await self._tab.evaluate("Number(sessionStorage.waxLost)")
        if not isinstance(lost_ms, float | int):
            raise MeasureError("hands-off: the page was told of nothing")
        since_s = clock.monotonic_s(lost_ms)
        await self._tab.key("keyUp", KEY)
        await self.drive()
        return self._stage.outcome(since_s, until_s)

    async def _press(self) -> None:
        await self._tab.key("keyUp", KEY)
        await asyncio.sleep(0.08)
        await self._tab.key("keyDown", KEY)


class _Touch:
    """Hold a button with a touch that the system cancels."""

    def __init__(self, stage: Stage, page: Chromium, points: TouchPoints) -> None:
        self._stage = stage
        self._page = page
        self._points = points
        self._is_down = False

    async def cancel(self) -> Stopping | None:
        await self._stage.moving(self._press)
        await random_phase()
        since_s = time.monotonic()
        await self._points.cancel()
        self._is_down = False
        await asyncio.sleep(_LOOK_S)
        return self._stage.outcome(since_s)

    async def _press(self) -> None:
        if self._is_down:
            await self._points.lift(0)
        await asyncio.sleep(0.08)
        self._is_down = True
        await self._points.press(0, self._page.viewer.button("Forward"))
