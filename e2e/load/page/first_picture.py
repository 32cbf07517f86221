"""From opening a link to a moving picture, over an emulated line."""

from __future__ import annotations

import asyncio
from contextlib import AsyncExitStack
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Final

from e2e.delay.browser import open_browser
from e2e.delay.cell import Cell
from e2e.delay.systems import start
from e2e.link import Link
from e2e.measure.errors import MeasureError
from e2e.measure.row import Row, judged, quantiles, summed

if TYPE_CHECKING:
    from e2e.delay.browser import Browser
    from e2e.delay.names import SystemName

_PAUSE_S: Final = 3.0
"""In this time the server forgets the viewer, and packets in flight leave the line."""
_MOVING: Final = Path(__file__).with_name("moving.js").read_text(encoding="utf-8")


async def first_picture(profile: str, goal_ms: float, peer: str | None, n: int) -> list[Row]:
    """Open the page `n` times with an empty cache; a first time before these does not count."""
    found_ms = await _times(profile, "audio-master", n)
    what = f"a link is opened → its picture moves: {profile}"
    rows = [summed(f"first-picture/{profile}", what, "ms", found_ms, goal_ms, judged="p95")]
    if peer is not None:
        times_ms = [one for one in await _times(profile, "stock", n) if one is not None]
        key = f"first-picture/{profile}: stock"
        rows.append(judged(key, f"… {peer}", "ms", quantiles(times_ms), n=n, column="median"))
    return rows


async def _times(profile: str, system: SystemName, n: int) -> list[float | None]:
    cell = Cell(experiment="G", profile=profile, system=system)
    async with AsyncExitStack() as leaving:
        served = leaving.enter_context(TemporaryDirectory(prefix="wax-load-"))
        link = await leaving.enter_async_context(Link(profile))
        running = await leaving.enter_async_context(start(cell, link, Path(served)))
        browser = await leaving.enter_async_context(open_browser(link))
        return [await _time(browser, running.url) for _ in range(n + 1)][1:]


async def _time(browser: Browser, url: str) -> float | None:
    async with browser.window(_MOVING) as window:
        await window.goto(url)
        found_ms = await window.evaluate("window.waxMovingMs")
    await asyncio.sleep(_PAUSE_S)
    if found_ms is None:
        return None
    if not found_ms > 0:
        raise MeasureError(f"{url}: a picture moves before the page is there: {found_ms} ms")
    return float(found_ms)
