"""One cell from the start of its server to its figures."""

from __future__ import annotations

import asyncio
import sys
import time
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from typing import TYPE_CHECKING, Final

import psutil

from e2e.delay.browser import fit, open_browser
from e2e.delay.measures import MEASURES, measured
from e2e.delay.names import OURS, profile
from e2e.delay.systems import start
from e2e.harness.page_clock import unix_ms
from e2e.instrument import PRELOAD, Instrument
from e2e.instrument.sharpness import sharpness
from e2e.instrument.sums import SETTLE_S
from e2e.link import Link
from e2e.load.crowd.crowd import gathered
from e2e.load.crowd.sample import Offering
from e2e.load.process import ProcessMeter
from e2e.measure.command import OUT
from e2e.measure.errors import MeasureError
from e2e.measure.row import Row

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable
    from pathlib import Path

    from playwright.async_api import Page

    from e2e.delay.browser import Browser
    from e2e.delay.cell import Cell

PICTURE_WITHIN_S: Final = 30.0
THIN_PICTURE_WITHIN_S: Final = 45.0
THIN_BPS: Final = 200_000
"""On a slower link than this the page alone takes several seconds."""
FETCH_EVERY_S: Final = 240.0
"""How often the readings are fetched: the page keeps ten minutes, and no shorter cell is
disturbed."""
BEYOND_S: Final = 100.0
"""How long a cell may take in addition to its own time before it counts as hung."""
_LOOKS: Final = 15
_LOOKING_S: Final = 3.0
"""After the figures: a look at the whole picture makes the page hold back pictures now and then."""
_HEARS_WITHIN_S: Final = 4.0
_LOOK_EVERY_S: Final = 0.1


class CrowdError(MeasureError):
    """The crowd did not get picture and sound."""


async def repeated(cell: Cell, n: int) -> list[Row]:
    """Measure a cell `n` times, each with a link, a server and a browser of its own.

    Raises `NotRunError` and `MeasureError`. For a peer or for the thesis's policy, having no
    picture is a result; a policy of ours without a picture has failed. A crowd for which server
    and machine do not suffice has no figures, and so misses every goal.
    """
    rows = []
    for repeat in range(n):
        one = cell.model_copy(update={"repeat": repeat})
        values: dict[str, float | None] = dict.fromkeys(MEASURES)
        try:
            values, detail = await _once(one)
        except CrowdError as error:
            detail = {"problem": str(error)}
            print(f"{one.key}: {error}", file=sys.stderr)  # the table only says missed
        else:
            if "problem" in detail and cell.system in OURS:
                raise MeasureError(str(detail["problem"]))
        detail["cell"] = one.model_dump()
        rows.append(Row(key=one.key, what=one.key, n=1, values=values, detail=detail))
    return rows


async def _once(cell: Cell) -> tuple[dict[str, float | None], dict[str, object]]:
    network = profile(cell.profile)
    network = network.model_copy(update={"seed": network.seed + cell.repeat})
    bound_s = cell.seconds + BEYOND_S
    logs = OUT / "delay" / "logs" / cell.key.replace("/", "-")
    logs.mkdir(parents=True, exist_ok=True)
    async with AsyncExitStack() as leaving:
        try:
            async with asyncio.timeout(bound_s):
                link = await leaving.enter_async_context(Link(network))
                browser = await leaving.enter_async_context(open_browser(link))
                return await _watch(cell, link, browser, logs)
        except TimeoutError as error:
            raise MeasureError(f"it hung and was cut off after {bound_s:.0f} s") from error


async def _watch(
    cell: Cell, link: Link, browser: Browser, folder: Path
) -> tuple[dict[str, float | None], dict[str, object]]:
    """Return figures and details; without a picture in time, those so far, and the problem."""
    values: dict[str, float | None] = {}
    began_ms, settle_s, problem = None, SETTLE_S, None
    async with AsyncExitStack() as leaving:
        running = await leaving.enter_async_context(start(cell, link, folder))
        page = await leaving.enter_async_context(browser.window(PRELOAD, cell.given))
        instrument = Instrument(page.evaluate, browser.ear)
        before = await link.statistics()
        is_thin = (link.profile.down.rate_bps or THIN_BPS) < THIN_BPS
        within_s = THIN_PICTURE_WITHIN_S if is_thin else PICTURE_WITHIN_S
        if await _goto(page, running.url, instrument, within_s):
            picture_s = time.monotonic()
            await running.opened(page)
            await fit(page, cell.given)
            await instrument.tap.hears(_HEARS_WITHIN_S)  # if nothing sounds, the figures say so
            settle_s = max(SETTLE_S, time.monotonic() - picture_s)
            if cell.viewers > 1:
                others = await leaving.enter_async_context(_crowd(cell, link, running.url))
                settle_s = time.monotonic() - picture_s + SETTLE_S
            began_ms = unix_ms(await link.start_changes())
            until_s = picture_s + settle_s + cell.seconds - SETTLE_S
            await asyncio.sleep(picture_s + settle_s - time.monotonic())
            failed_s = await running.fail_safe_s()
            costs = await _costs(running.pid, browser)
            psutil.cpu_percent()
            await _wait(instrument, until_s)
            values["machine_busy"] = psutil.cpu_percent()
            values |= _shares(costs, await _costs(running.pid, browser))
            if failed_s is not None:
                values["fail_safe_s"] = max(0.0, (await running.fail_safe_s() or 0.0) - failed_s)
            if cell.viewers > 1:
                values["crowd_least_per_s"] = await others()
        else:
            problem = f"there was no picture within {within_s:.0f} s"
            values["sharpness_ssim"] = 0.0  # nothing is like the source
        readings = await instrument.readings()
        after = await link.statistics()
        delivered = after.delivered - before.delivered
        late = after.late - before.late
        values["link_late_percent"] = 100 * late / delivered if delivered else 0.0
        if problem is None:
            values |= await _sharpness(instrument, cell)
    values |= measured(cell, readings, settle_s, began_ms)
    detail: dict[str, object] = {"problem": problem} if problem else {}
    return values, detail


async def _sharpness(instrument: Instrument, cell: Cell) -> dict[str, float]:
    await instrument.look(_LOOKS, _LOOKING_S / _LOOKS)
    await asyncio.sleep(_LOOKING_S)
    pictures = (await instrument.readings()).pictures
    return sharpness(await instrument.looks(), pictures, cell.given)


@asynccontextmanager
async def _crowd(cell: Cell, link: Link, url: str) -> AsyncIterator[Callable[[], Awaitable[float]]]:
    """Add the cell's other viewers at the server's end; raises `CrowdError`.

    There they load neither the link nor the browser's decoder. Yields a function that returns the
    least picture rate of those who are not behind a modem. LiveKit's viewers join through its own
    library and not by one offer; no planned cell has them.
    """
    offering = Offering(url.rstrip("/"), "stock" if cell.system == "stock" else "wax")
    async with gathered(offering, slow=cell.slow, through=link.server.command) as others:
        try:
            await others.hold(cell.viewers - 1)
        except MeasureError as error:
            raise CrowdError(str(error)) from error
        first = await others.count()

        async def least_per_s() -> float:
            last = await others.count()
            pairs = list(zip(first.viewers, last.viewers, strict=True))[cell.slow :]
            fewest = min(after.video.frames - before.video.frames for before, after in pairs)
            return fewest / (last.at_s - first.at_s)

        yield least_per_s


async def _costs(pid: int, browser: Browser) -> dict[str, float]:
    """Return the processor times of server and browser in s, by the names of their shares."""
    try:
        meter = ProcessMeter(pid)
        server = {"server_cpu": meter.cpu_s(), "server_memory_mib": meter.rss_mib()}
    except psutil.NoSuchProcess as error:
        raise MeasureError("the server has ended; its last words are in its log") from error
    return {**server, "browser_cpu": await browser.cpu_s(), "at_s": time.monotonic()}


def _shares(before: dict[str, float], after: dict[str, float]) -> dict[str, float]:
    """Return the use of one core in %, and the memory."""
    span_s = after["at_s"] - before["at_s"]
    used = {name: max(0.0, after[name] - before[name]) for name in ("server_cpu", "browser_cpu")}
    shares = {name: 100 * used_s / span_s for name, used_s in used.items()}
    return {**shares, "server_memory_mib": after["server_memory_mib"]}


async def _wait(instrument: Instrument, until_s: float) -> None:
    """Wait, and fetch the readings before the page has to forget them."""
    while (left_s := until_s - time.monotonic()) > FETCH_EVERY_S:
        await asyncio.sleep(FETCH_EVERY_S)
        await instrument.readings()
    await asyncio.sleep(left_s)


async def _goto(page: Page, url: str, instrument: Instrument, within_s: float) -> bool:
    """Open the page; return whether there is a picture in time."""
    with suppress(TimeoutError):
        async with asyncio.timeout(within_s):
            await page.goto(url)
            while not await instrument.sees_picture():  # noqa: ASYNC110  # it is in the browser
                await asyncio.sleep(_LOOK_EVERY_S)
            return True
    return False
