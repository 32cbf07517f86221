"""The faults of a page: its browser frozen or killed, its camera frozen, its operator elsewhere."""

from __future__ import annotations

import asyncio
import signal
import time
from contextlib import asynccontextmanager
from functools import partial
from typing import TYPE_CHECKING, Final

from playwright.async_api import async_playwright

from e2e.harness.chromium import launch_chromium
from e2e.harness.headset import SMALL, EmulatedHeadset, worn
from e2e.harness.page_clock import page_clock
from e2e.harness.viewer import Viewer
from e2e.measure.errors import MeasureError
from e2e.stop.page import Tab, chromiums
from wax.config.settings import Settings

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable

    from e2e.stop.fault import Scene
    from e2e.stop.page import Chromium

AGE_MS: Final = Settings().drive.stop_picture_age_ms
"""The shipped limit of the picture's age; the link's own delay is added."""
_NOTE: Final = """
for (const type of ["blur", "visibilitychange"])
    addEventListener(type, () => { window.waxLost ??= performance.now(); }, true);
"""
"""Notes when the page got its first event."""


class Wheel:
    """The page that drives, and the next one in the queue."""

    page: Chromium
    waits: Chromium

    def __init__(self, launch: Callable[[], Awaitable[Chromium]]) -> None:
        self.launch = launch

    async def press(self) -> None:
        await self.page.press()

    async def queue(self) -> None:
        """Open the next page, and let it wait for its turn."""
        self.waits = await self.launch()
        await self.waits.viewer.join()


@asynccontextmanager
async def driven(scene: Scene, *, queued: bool = False) -> AsyncIterator[None]:
    """Let a page drive; with `queued` another one waits."""
    async with chromiums() as launch:
        wheel = scene.prop = Wheel(partial(launch, scene.stage.server.url))
        scene.press = wheel.press
        wheel.page = await wheel.launch()
        await wheel.page.viewer.takes_the_wheel(15)
        if queued:
            await wheel.queue()
        yield


async def thaw(scene: Scene) -> None:
    scene.prop.page.send(signal.SIGCONT)


async def follow(scene: Scene) -> None:
    """Let the next in the queue drive."""
    wheel: Wheel = scene.prop
    await wheel.page.close()
    wheel.page = wheel.waits
    await wheel.page.viewer.drives(15)
    await wheel.queue()


async def freeze_camera(scene: Scene) -> float:
    return float(await scene.rig.freeze())


async def thaw_camera(scene: Scene) -> None:
    scene.rig.thaw()
    await asyncio.sleep(0.5)


# --- the operator lets go ------------------------------------------------------------------------


@asynccontextmanager
async def tab(scene: Scene, *, script: str = "") -> AsyncIterator[None]:
    """Let a tab drive, and note when it is hidden; `script` runs in it before the page's own."""
    async with Tab.opened(scene.stage.server.url, _NOTE + script) as held:
        await held.drive()
        scene.prop, scene.press = held, held.press
        yield


@asynccontextmanager
async def headset(scene: Scene) -> AsyncIterator[None]:
    """Let somebody drive who wears a headset."""
    async with async_playwright() as playwright, await launch_chromium(playwright) as browser:
        context = await browser.new_context(**SMALL)
        await context.add_init_script(worn())
        viewer = await Viewer.at(context, scene.stage.server.url)
        await viewer.sees_picture()
        await viewer.takes_the_wheel(15)
        worn_one = await EmulatedHeadset.entered(viewer)

        async def press() -> None:
            await worn_one.let_go()
            await worn_one.turn_left()

        scene.prop, scene.press = worn_one, press
        yield


async def take_off(scene: Scene) -> float:
    since_s = time.monotonic()
    await scene.prop.become("hidden")
    return since_s


async def put_on(scene: Scene) -> None:
    await scene.prop.become("visible")


async def hide(scene: Scene) -> float:
    """Open another tab in front of the page."""
    held: Tab = scene.prop
    held.clock = await page_clock(held.page.evaluate)
    await held.page.evaluate("delete window.waxLost")
    held.other = await held.page.context.new_page()
    return time.monotonic()


async def show(scene: Scene) -> float:
    """Return to the page; return when its first event was."""
    held: Tab = scene.prop
    await held.other.close()
    lost_ms = await held.page.evaluate("window.waxLost ?? null")
    if not isinstance(lost_ms, float | int):
        raise MeasureError("another-tab: the page was told of nothing")
    await held.release()
    return held.clock.monotonic_s(lost_ms)
