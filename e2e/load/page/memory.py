"""Whether the page's memory stays flat while somebody drives for half an hour."""

from __future__ import annotations

import asyncio
import time
from dataclasses import dataclass
from statistics import linear_regression
from typing import TYPE_CHECKING, Final

from e2e.load.page.driven import Counters, browsing, drives
from e2e.measure.errors import MeasureError
from e2e.measure.row import Row, judged

if TYPE_CHECKING:
    from collections.abc import Sequence

    from playwright.async_api import Page

GOAL_MIB: Final = 1.0
_MIB: Final = 1 << 20
_EVERY_S: Final = 20.0
_KEYS: Final = ("ArrowLeft", "ArrowRight")
_HOLD_S: Final = 1.0
FEWEST: Final = 4


@dataclass(frozen=True, slots=True)
class Reading:
    """After garbage was collected; `listeners` are event listeners."""

    at_min: float
    heap_mib: float
    nodes: float
    listeners: float


async def memory(n: int) -> list[Row]:
    """Drive for `n` minutes, to and fro, and read the heap again and again."""
    async with browsing({}) as (browser, url):
        context = await browser.new_context(locale="en-GB")
        viewer = await drives(context, url)
        counters = await Counters.of(viewer.page)
        since_s = time.monotonic()
        readings = []
        while (now_s := time.monotonic()) <= since_s + 60 * n:
            readings.append(await _reading(counters, (now_s - since_s) / 60))
            await _drive_until(viewer.page, now_s + _EVERY_S)
        await context.close()
    return rows(readings, n)


def rows(readings: Sequence[Reading], minutes: float) -> list[Row]:
    """Return what grows over `minutes`, by the slope of the second half.

    In the first one caches fill that stay, and what leaks goes on leaking. Raises `MeasureError`
    for too few readings.
    """
    if len(readings) < FEWEST:
        raise MeasureError(f"{len(readings)} readings are too few for a slope")
    late = readings[len(readings) // 2 :]
    at_min = [one.at_min for one in late]

    def grown(values: Sequence[float]) -> float:
        return linear_regression(at_min, values).slope * minutes

    heap = grown([one.heap_mib for one in late])
    return [
        judged(
            "memory",
            f"growth of the page’s heap over {minutes:g} min of driving",
            "MiB",
            {"median": heap},
            GOAL_MIB,
            n=len(readings),
            column="median",
            detail={
                "heap_mib": [round(one.heap_mib, 2) for one in readings],
                "nodes": grown([one.nodes for one in late]),
                "listeners": grown([one.listeners for one in late]),
            },
        )
    ]


async def _reading(counters: Counters, at_min: float) -> Reading:
    await counters.collect_garbage()
    told = await counters.read()
    heap_mib = told["JSHeapUsedSize"] / _MIB
    return Reading(at_min, heap_mib, told["Nodes"], told["JSEventListeners"])


async def _drive_until(page: Page, until_s: float) -> None:
    while time.monotonic() < until_s:
        for key in _KEYS:
            await page.keyboard.down(key)
            await asyncio.sleep(_HOLD_S)
            await page.keyboard.up(key)
