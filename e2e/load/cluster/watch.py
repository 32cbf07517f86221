"""How old picture, sound and state are in a room, beside a page at the robot's own server."""

from __future__ import annotations

import asyncio
import random
import re
import statistics
from itertools import pairwise
from typing import TYPE_CHECKING, Final

from e2e.instrument.bursts import bursts, skews_ms
from e2e.instrument.sums import picture_ages
from e2e.load.cluster.driving import driving
from e2e.load.cluster.page import browsers, now_ms
from e2e.load.cluster.stage import staged
from e2e.measure.errors import MeasureError
from e2e.measure.row import Row, timed
from e2e.measure.summary import summarize

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.delay.readings import Readings
    from e2e.load.cluster.driving import Driving
    from e2e.load.cluster.page import Page

WINDOW_S: Final = 20.0
PICTURE_MS: Final = 15.0
SKEW_MS: Final = 20.0
STATE_MS: Final = 1200.0
_SETTLE_S: Final = 12.0
"""Both pages hold the picture back for the sound by then, a step at a time."""
_RENAMED_S: Final = (2.2, 3.2)
"""A name may change each two seconds; at random phase against what is told once a second."""
_DRIVER: Final = re.compile(r"Ada (\d+) is driving")


class Window:
    """One page, from `from_ms` to `to_ms`: ages of pictures when shown, and skews, ms."""

    def __init__(self, readings: Readings, from_ms: float, to_ms: float) -> None:
        ages = picture_ages(readings.pictures)
        self.ages_ms = [age for at, age in ages if from_ms <= at <= to_ms]
        heard = bursts(readings.sound, readings.heard_counters, ages)
        inside = [one for one in heard if from_ms <= one.heard_ms <= to_ms]
        self.skews_ms = [abs(skew) for skew in skews_ms(inside, ages)]
        if not self.ages_ms or not self.skews_ms:
            raise MeasureError("a page showed or sounded nothing")

    @property
    def p50_ms(self) -> float:
        return statistics.median(self.ages_ms)


async def watch(n: int) -> list[Row]:
    """Watch at both for `n` windows, while somebody drives."""
    async with (
        staged(server={"max_viewers": 2}) as stage,
        browsers() as chromium,
        driving(stage) as found,
    ):
        here = await chromium.open(stage.server.url, loud=True)
        await here.shows("server")
        there = await chromium.open(stage.server.url, loud=True)
        await there.shows("room")
        for page in (here, there):
            await page.instrument.hears(within_s=_SETTLE_S)
        await asyncio.sleep(_SETTLE_S)
        edges_ms = [now_ms()]
        renaming = asyncio.create_task(_rename(found), name="renaming")
        for _ in range(n):
            await asyncio.sleep(WINDOW_S)
            edges_ms.append(now_ms())
        renaming.cancel()
        state_ms = await _state_ages_ms(there, edges_ms)
        at_room, at_server = [await _windows(page, edges_ms) for page in (there, here)]
    later_ms = [a.p50_ms - b.p50_ms for a, b in zip(at_room, at_server, strict=True)]
    return [
        _ages("watch: room", "a picture in a room, age when shown", at_room),
        _ages("watch: server", "… at the robot's own server, at the same time", at_server),
        timed(
            "watch: later", "… the room's p50 of 20 s, more by", later_ms, PICTURE_MS,
            judged="median",
        ),
        timed(
            "watch: skew",
            "between picture and sound in a room",
            [skew for one in at_room for skew in one.skews_ms],
            SKEW_MS,
            judged="p95",
            server=str(summarize([skew for one in at_server for skew in one.skews_ms])),
            windows=[round(summarize(one.skews_ms).p95, 1) for one in at_room],
        ),
        timed("watch: state", "a change of state → a page in a room says so", state_ms, STATE_MS),
    ]  # fmt: skip


def _ages(key: str, what: str, windows: Sequence[Window]) -> Row:
    ages_ms = [age for one in windows for age in one.ages_ms]
    spread = summarize(ages_ms)
    values = spread.model_dump(exclude={"n", "mean", "sd"})
    return Row(key=key, what=what, n=len(ages_ms), unit="ms", values=values, spread=spread)


async def _windows(page: Page, edges_ms: Sequence[float]) -> list[Window]:
    readings = await page.readings()
    return [Window(readings, from_ms, to_ms) for from_ms, to_ms in pairwise(edges_ms)]


async def _rename(operator: Driving) -> None:
    """Have the operator called by the time, again and again."""
    while True:
        operator.call(f"Ada {now_ms():.0f}")
        await asyncio.sleep(random.uniform(*_RENAMED_S))


async def _state_ages_ms(page: Page, edges_ms: Sequence[float]) -> list[float]:
    """Return how long each name was on its way to the page."""
    came_ms: dict[float, float] = {}
    for at_ms, text in await page.said("turn"):
        if found := _DRIVER.search(text):
            came_ms.setdefault(float(found[1]), at_ms)
    inside = [(named, at) for named, at in came_ms.items() if edges_ms[0] <= at <= edges_ms[-1]]
    return [at_ms - named_ms for named_ms, at_ms in inside]
