"""What a camera beside the driving view costs that view: with the other off and large, by turns."""

from __future__ import annotations

import asyncio
import statistics
import time
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final

from e2e.browsers import open_browser
from e2e.delay.cell import Cell
from e2e.delay.systems import origin
from e2e.delay.systems.served import STATE, serving
from e2e.delay.systems.settings import settings
from e2e.delay.systems.wax import Wax
from e2e.harness import toml
from e2e.link import Link, UnavailableError
from e2e.load.servers import WAX
from e2e.measure.errors import MeasureError, NotRunError
from e2e.measure.row import Row, judged
from e2e.measure.summary import summarize

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Sequence

    from e2e.browsers import Window

_PROBE: Final = Path(__file__).parents[1] / "harness" / "probe.js"
_CAMERA: Final = {"camera": [{"name": "Second", "source": "testcard"}]}
_SECONDS: Final = 10.0
_SETTLE_S: Final = 5.0
_SEES_WITHIN_S: Final = 60.0
_READ: Final = 10
"""Pictures that are read off at a time."""
_MORE_MS: Final = 3.0
_THIN: Final = "modem-56k"
_LARGE_PX: Final = 640
_SECOND_PX: Final = "document.querySelectorAll('video')[1].videoWidth"
_SETTINGS: Final = """
[...document.querySelectorAll("button")].find((one) => one.innerText === "Settings").click()
"""
_SWITCH: Final = """
[...document.querySelectorAll('[role="switch"]')]
  .find((one) => one.innerText === "Other cameras").click()
"""


@dataclass(frozen=True, slots=True)
class Stretch:
    """What came of the driving view meanwhile: ages in ms, and each second's rendition."""

    ages_ms: list[float]
    renditions: list[str]
    second_px: int
    """How wide the other camera's newest picture is."""


@dataclass(frozen=True, slots=True)
class _Stage:
    window: Window
    system: Wax

    async def show(self, *, is_on: bool) -> None:
        """Show the other camera large, or not at all."""
        large = "Second" if is_on else "Driving view"
        tap = f"""document.querySelector('[aria-label="Make {large} large"]')?.click()"""
        for act in (_SWITCH, tap) if is_on else (tap, _SWITCH):
            await self.window.evaluate(act)
        await asyncio.sleep(_SETTLE_S)

    async def watched(self) -> Stretch:
        ages_ms: list[float] = []
        renditions: list[str] = []
        until_s = time.monotonic() + _SECONDS
        while time.monotonic() < until_s:
            cards = await self.window.evaluate(f"waxProbe.cards({_READ})")
            ages_ms += [card["age_ms"] for card in cards if card["valid"]]
            told = await self.system.told()
            renditions.append(str(told.get("viewer.streams.rendition")))
        second_px = int(await self.window.evaluate(_SECOND_PX))
        if not ages_ms:
            raise MeasureError("no picture of the driving view could be read")
        return Stretch(ages_ms, renditions, second_px)


async def cameras(n: int) -> list[Row]:
    """Watch `n` pairs on one machine, and as many on a line that carries one picture."""
    wide = await _pairs("same-machine", n)
    if any(on.second_px != _LARGE_PX for _, on in wide):
        raise MeasureError("the other camera was not sent on one machine")
    return rows_of(wide, await _pairs(_THIN, n))


def rows_of(
    wide: Sequence[tuple[Stretch, Stretch]], thin: Sequence[tuple[Stretch, Stretch]]
) -> list[Row]:
    """Compare the pairs' medians; on the thin line count the seconds with another rendition."""
    more_ms = [statistics.median(on.ages_ms) - statistics.median(off.ages_ms) for off, on in wide]
    alone = {name for off, _ in thin for name in off.renditions}
    beside = [name for _, on in thin for name in on.renditions]
    return [
        judged(
            "cameras: age",
            "a second camera large: more age of the driving view, median of the pairs’ p50",
            "ms",
            {WAX: statistics.median(more_ms)},
            _MORE_MS,
            n=len(wide),
            spread=summarize(more_ms),
            load="an operator, two test cards at 640×480",
        ),
        judged(
            "cameras: rendition",
            f"… {_THIN}: readings in which its rendition is another than alone",
            "",
            {WAX: float(sum(name not in alone for name in beside))},
            0.0,
            n=len(beside),
            detail={"alone": sorted(alone), "beside": sorted(set(beside))},
        ),
    ]


async def _pairs(profile: str, n: int) -> list[tuple[Stretch, Stretch]]:
    """Return each pair's stretches, alone and beside the other; every second pair begins so."""
    found: list[tuple[Stretch, Stretch]] = []
    async with _staged(profile) as stage:
        await stage.window.evaluate(_SETTINGS)
        await stage.window.evaluate(_SWITCH)  # small at first, so it is off now
        is_on = False
        await asyncio.sleep(_SETTLE_S)
        for _ in range(n):
            pair: dict[bool, Stretch] = {is_on: await stage.watched()}
            is_on = not is_on
            await stage.show(is_on=is_on)
            pair[is_on] = await stage.watched()
            found.append((pair[False], pair[True]))
    return found


@asynccontextmanager
async def _staged(profile: str) -> AsyncIterator[_Stage]:
    """Have an operator's page open on a server with a second camera."""
    cell = Cell(experiment="G", profile=profile, system="operator")
    async with AsyncExitStack() as leaving:
        folder = Path(leaving.enter_context(TemporaryDirectory(prefix="wax-bench-")))
        config = folder / "wax.toml"
        tree: dict[str, Any] = toml.merged(_CAMERA, settings(cell, "testcard"))
        config.write_text(toml.dumps(tree), encoding="utf-8")
        try:
            link = await leaving.enter_async_context(Link(profile))
        except UnavailableError as error:
            raise NotRunError(str(error)) from error
        arguments = ["-m", "wax", "--config", str(config)]
        served = await leaving.enter_async_context(serving("wax", link, folder, arguments, {}))
        await served.become_host(folder / STATE / "wax")
        browser = await leaving.enter_async_context(
            open_browser(cell.browser, link, [origin(link)], folder)
        )
        window = await leaving.enter_async_context(
            browser.window(_PROBE.read_text(encoding="utf-8"))
        )
        await window.goto(served.url)
        until_s = time.monotonic() + _SEES_WITHIN_S
        while not await window.evaluate("waxProbe.playing()"):
            if time.monotonic() > until_s:
                raise MeasureError(f"there was no picture within {_SEES_WITHIN_S:g} s")
            await asyncio.sleep(0.1)
        system = Wax(served, joins=True)
        await system.opened(window)
        yield _Stage(window, system)
