"""Typing at a robot of any driver; what the drivers' suite of old imports."""

from __future__ import annotations

import asyncio
import random
from typing import TYPE_CHECKING, Any, Final

from playwright.async_api import async_playwright

from e2e.harness.chromium import launch_chromium
from e2e.harness.page_clock import page_clock
from e2e.harness.viewer import Viewer
from e2e.load.servers import WAX, serving
from e2e.load.strokes import HOLD_S, REST_S, Stroke, changes, delays

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["GOAL_MS", "changes", "delays", "strokes_at"]

GOAL_MS: Final = 25.0
_KEY: Final = "ArrowUp"
_SETTLE_S: Final = 1.0
_KEYS: Final = """
(() => {
  window.waxBenchKeys = [];
  const note = (event) => {
    if (!event.isTrusted || event.repeat) return;
    window.waxBenchKeys.push([event.type, event.code, event.timeStamp]);
  };
  addEventListener("keydown", note, { capture: true });
  addEventListener("keyup", note, { capture: true });
})();
"""
"""Notes each key that goes down or up, with the time of the browser's event."""


async def strokes_at(
    robot: Mapping[str, Any],
    n: int,
    environment: Mapping[str, str] | None = None,
    *,
    hold_s: tuple[float, float] = HOLD_S,
    rest_s: tuple[float, float] = REST_S,
) -> tuple[list[Stroke], float]:
    """Drive that robot and type; gives the strokes, and how well their clock is known in ms."""
    async with (
        serving(WAX, environment=environment, robot=robot) as server,
        async_playwright() as playwright,
    ):
        browser = await launch_chromium(playwright)
        viewer = await Viewer.prepare(await browser.new_context(), server.url)
        await viewer.page.add_init_script(_KEYS)
        await viewer.page.goto(server.url)
        await viewer.call_oneself("Bench")
        await viewer.join()
        await viewer.drives()
        await asyncio.sleep(_SETTLE_S)
        before = await page_clock(viewer.page.evaluate)
        for _ in range(n):
            await viewer.page.keyboard.down(_KEY)
            await asyncio.sleep(random.uniform(*hold_s))
            await viewer.page.keyboard.up(_KEY)
            await asyncio.sleep(random.uniform(*rest_s))
        after = await page_clock(viewer.page.evaluate)
        noted = await viewer.page.evaluate("window.waxBenchKeys")
        await browser.close()
    clock, drift_s = min(before, after), abs(before.ahead_s - after.ahead_s)
    strokes = [
        Stroke(kind == "keydown", clock.monotonic_s(made_ms) * 1000)
        for kind, code, made_ms in noted
        if code == _KEY
    ]
    return strokes, max(before.error_s, after.error_s, drift_s) * 1000
