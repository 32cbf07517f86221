"""One cell from the start of its server to its figures."""

from __future__ import annotations

import asyncio
import time
from contextlib import AsyncExitStack, suppress
from typing import TYPE_CHECKING, Final, TypeVar

from e2e.delay.crowd import crowd
from e2e.delay.process import BrowserMeter, CostMeter, MachineMeter
from e2e.delay.results import Carried, CellResult
from e2e.delay.systems import start
from e2e.delay.talking_head.lips import lip_lag
from e2e.delay.talking_head.quality import speech_quality
from e2e.delay.talking_head.voice import speak
from e2e.instrument import PRELOAD, Instrument, figures
from e2e.measure.ear import BLOCK_MS
from wax.clock import SystemClock

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Sequence
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray
    from tests.link.counters import Counters

    from e2e.browsers import Browser, Window
    from e2e.delay.cell import Cell
    from e2e.delay.figures import Figures
    from e2e.delay.readings import Readings
    from e2e.link import Link
    from e2e.link.statistics import Lateness, Statistics

S = TypeVar("S")
T = TypeVar("T")

SETTLE_S: Final = 3.0
"""Not counted at the begin of a cell; longer where the page needs more until it plays."""
PICTURE_WITHIN_S: Final = 30.0
THIN_PICTURE_WITHIN_S: Final = 45.0
THIN_BPS: Final = 200_000
"""On a slower link than this the page alone takes several seconds."""
FETCH_EVERY_S: Final = 240.0
"""The page keeps ten minutes; nothing shorter is disturbed."""
LATE_MS: Final = 5.0
RISING: Final = tuple(f"viewer.streams.{one}" for one in ("fail_safe_s", "sent", "skipped", "lost"))
"""What WAX counts of the viewer since it came; a cell is told what came of it in its own time."""
_HEARS_WITHIN_S: Final = 4.0
_LOOK_EVERY_S: Final = 0.1


async def watch(cell: Cell, link: Link, browser: Browser, folder: Path) -> CellResult:
    """Measure `cell` on a link and a browser that stand; `folder` is for the server's own files.

    Without a picture in time the result says so and has the figures of what there was. Raises
    `NotRunError`, `MeasureError`, `LinkError`, and whatever a browser that fails raises.
    """
    told: dict[str, float | str] = {}
    until_now: dict[str, float | str] = {}
    browser_cpu_share = None
    async with AsyncExitStack() as leaving:
        running, window = await _both(
            leaving.enter_async_context(start(cell, link, folder)),
            leaving.enter_async_context(browser.window(PRELOAD)),
        )
        speaks = cell.content == "talking-head"
        instrument = Instrument(window.evaluate, browser.ear, records=speaks)
        server = CostMeter(running.pid, f"the server of {cell.system}")
        before = await link.statistics()
        within_s = picture_within_s(link)
        sees = await _goto(window, running.url, instrument, within_s)
        settle_s, picture_s = SETTLE_S, time.monotonic()
        if sees:
            await running.opened(window)
            await instrument.hears(_HEARS_WITHIN_S)  # what never sounds is seen in the readings
            settle_s = max(SETTLE_S, time.monotonic() - picture_s)
            if cell.viewers > 1:
                others = await leaving.enter_async_context(crowd(cell, link, running.url))
                settle_s = time.monotonic() - picture_s + SETTLE_S
            server = CostMeter(running.pid, f"the server of {cell.system}")
            before = await link.statistics()
            told["changes_began_ms"] = _unix_ms(await link.start_changes())
            from_s = picture_s + settle_s
            await asyncio.sleep(from_s - time.monotonic())
            until_now = await running.told()
            told["counted_from_ms"] = SystemClock().wall_ms()
            busy = MachineMeter()
            browsers = await BrowserMeter.start(browser)
            await _wait(instrument, from_s + cell.seconds - SETTLE_S)
            told["machine.busy_share"] = busy.read()
            browser_cpu_share = await browsers.read()
            if cell.viewers > 1:
                told |= await others.told()
        readings = await instrument.readings()
        cost = server.read()
        after = await link.statistics()
        told |= since(until_now, await running.told())
    told["link.late_share"] = _late_share(before, after)
    return CellResult(
        cell=cell,
        problem=None if sees else f"there was no picture within {within_s:.0f} s",
        figures=summed(cell, readings, instrument.recorded, settle_s=settle_s),
        readings=readings,
        down=_carried(before.down, after.down),
        up=_carried(before.up, after.up),
        server=cost,
        browser_cpu_share=browser_cpu_share,
        told=told,
    )


async def _wait(instrument: Instrument, until_s: float) -> None:
    """Let time pass, and fetch what was read before the page has to forget it."""
    while (left_s := until_s - time.monotonic()) > FETCH_EVERY_S:
        await asyncio.sleep(FETCH_EVERY_S)
        await instrument.readings()
    await asyncio.sleep(left_s)


def picture_within_s(link: Link) -> float:
    """Return how long the first picture is waited for on this link."""
    rate_bps = link.profile.down.rate_bps
    thin = rate_bps is not None and rate_bps < THIN_BPS
    return THIN_PICTURE_WITHIN_S if thin else PICTURE_WITHIN_S


async def _both(one: Awaitable[S], other: Awaitable[T]) -> tuple[S, T]:
    """Await both, and only when neither goes on any more raise what one of them raised."""
    first, second = await asyncio.gather(one, other, return_exceptions=True)
    if isinstance(first, BaseException):
        raise first
    if isinstance(second, BaseException):
        raise second
    return first, second


async def _goto(window: Window, url: str, instrument: Instrument, within_s: float) -> bool:
    """Open the page and return whether there is a picture in time."""
    with suppress(TimeoutError):
        async with asyncio.timeout(within_s):
            await window.goto(url)
            await _until(instrument.sees_picture)
            return True
    return False


async def _until(is_so: Callable[[], Awaitable[bool]]) -> None:
    while not await is_so():  # noqa: ASYNC110  # it is in the browser
        await asyncio.sleep(_LOOK_EVERY_S)


def since(before: dict[str, float | str], after: dict[str, float | str]) -> dict[str, float | str]:
    """Give what a system tells `after`, of `RISING` only what came since `before`.

    A viewer that joined anew in between has been counted from 0 again.
    """
    found = dict(after)
    if before.get("viewer.id") != after.get("viewer.id"):
        return found
    for name in RISING:
        old, new = before.get(name), after.get(name)
        if isinstance(old, float) and isinstance(new, float):
            found[name] = new - old
    return found


def summed(
    cell: Cell,
    readings: Readings,
    recorded: Sequence[NDArray[np.float32]] = (),
    *,
    settle_s: float,
) -> Figures:
    """Sum up what was read, and judge lips and voice where there were any."""
    found = figures(readings, settle_s=settle_s)
    if cell.content != "talking-head":
        return found
    blocks = round((found.to_ms - found.from_ms) / BLOCK_MS)
    update = {"speech_quality": speech_quality(speak(), recorded[-blocks:])} if recorded else {}
    lag = lip_lag(readings, from_ms=found.from_ms, to_ms=found.to_ms)
    if lag is not None:
        update |= {"lip_lag_ms": lag.lag_ms, "lip_correlation": lag.correlation}
    return found.model_copy(update=update)


def _carried(before: Counters, after: Counters) -> Carried:
    return Carried(
        packets=after.packets_out - before.packets_out,
        bytes=after.bytes_out - before.bytes_out,
        queue_drops=after.queue_drops - before.queue_drops,
        losses=after.losses - before.losses,
    )


def _late_share(before: Statistics, after: Statistics) -> float:
    """Of the packets, how many the emulator itself delivered more than `LATE_MS` too late."""
    late = total = 0
    for old, new in ((before.down_late, after.down_late), (before.up_late, after.up_late)):
        total += sum(new.packets) - sum(old.packets)
        late += _beyond(new) - _beyond(old)
    return late / total if total else 0.0


def _beyond(late: Lateness) -> int:
    return sum(late.packets[late.up_to_ms.index(LATE_MS) + 1 :])


def _unix_ms(monotonic_s: float) -> float:
    return SystemClock().wall_ms() - (time.monotonic() - monotonic_s) * 1000
