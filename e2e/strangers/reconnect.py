"""How soon the picture is back once the link is, whether the turn is kept, and the robot still.

The ways to lose the link: every packet is lost for five seconds and no event tells of it, and the
browser's machine gets another address, at once or after some time without any, as a phone does that
leaves the house. A key is held all the time.
"""

from __future__ import annotations

import asyncio
import random
import tempfile
import time
from contextlib import AsyncExitStack, asynccontextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Final

import tomlkit
from playwright.async_api import async_playwright
from tests.link.profile import Change, Loss, load

from e2e.delay.systems.served import PORT
from e2e.delay.systems.wax import serving
from e2e.harness.chromium import chromium_at
from e2e.harness.page_clock import unix_ms
from e2e.harness.robot import moves
from e2e.harness.toml import MEDIA
from e2e.harness.viewer import Viewer
from e2e.harness.wait import eventually
from e2e.link import Link
from e2e.link.namespace import BROWSER_ADDRESS, DEVICE
from e2e.measure.errors import MeasureError
from e2e.measure.row import Row, summed

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable, Sequence

    from tests.link.profile import DirectionSettings, Profile

    from e2e.delay.systems.wax import Wax

    Fault = Callable[[], Awaitable[float]]

OUTAGE_S: Final = 5.0
GOALS_MS: Final = {
    "outage": (1200.0, 2000.0),
    "network": (700.0, 1200.0),
    "absence": (700.0, 1200.0),
}
"""Of the median and the 95th percentile."""

_NETWORK: Final = "internet-5m"
_NEXT_ADDRESS: Final = "10.77.0.3"
_WITHOUT_S: Final = {"network": (0.0, 1.0), "absence": (2.0, 3.0)}
"""From the old address to the new one, as a phone hands over or looks for another network."""
_KEY: Final = "ArrowLeft"
_PRESSES: Final = 3
_BACK_WITHIN_S: Final = 12.0
_DRIVES_WITHIN_S: Final = 15.0
_LET_GO_S: Final = 0.3
"""In which the page says several times that nothing is held."""
_STILL_S: Final = 0.6
_SLOT_S: Final = 18.0
"""From one outage to the next: the longest outage, time to settle, and a return that is late."""
_SETTLE_S: Final = (3.0, 4.0)
"""From a picture to the next fault: as steady as any, and at a random phase of every timer."""

_SERVER: Final = {"host": "0.0.0.0", "port": PORT}
_SETTINGS: Final = {**MEDIA, "turns": {"turn_s": 3600.0}}


class Driving:
    """A browser that drives, behind a link that can be cut at these times after its begin."""

    def __init__(
        self,
        link: Link,
        server: Wax,
        log: Path,
        viewer: Viewer,
        outages_s: Sequence[tuple[float, float]],
    ) -> None:
        self.viewer = viewer
        self._server = server
        self._link = link
        self._log = log
        self._addresses = (BROWSER_ADDRESS, _NEXT_ADDRESS)
        self._left_s = iter(outages_s)
        self._began_s: float | None = None

    def turns(self) -> int:
        """Count the turns that have begun, by the server's log."""
        return self._log.read_text(encoding="utf-8").count("TurnStarted")

    async def drives_again(self) -> bool:
        """Wait until the page drives; return False if it had to queue for it."""
        driving = self.viewer.page.get_by_text("You are driving")
        joins = self.viewer.page.get_by_role("button", name="Join the queue")
        kept = True

        async def drives() -> bool:
            nonlocal kept
            if not (is_so := await driving.is_visible()) and await joins.is_visible():
                await joins.click()
                kept = False
            return is_so

        await eventually(drives, "the page drives again", within_s=_DRIVES_WITHIN_S)
        return kept

    async def black_hole(self) -> float:
        """Lose every packet for a while; return when that ended, as Unix milliseconds."""
        if self._began_s is None:
            self._began_s = await self._link.start_changes()
        begin_s, end_s = (self._began_s + at_s for at_s in next(self._left_s))
        if begin_s < time.monotonic():
            raise MeasureError("the page came back too late for the next outage")
        await asyncio.sleep(end_s - time.monotonic())
        return unix_ms(end_s)

    async def other_network(self, without_s: tuple[float, float]) -> float:
        """Give the browser's machine another address, after a while without; return when."""
        old, new = self._addresses
        self._addresses = new, old
        await self._ip("address", "del", f"{old}/24", "dev", DEVICE)
        await asyncio.sleep(random.uniform(*without_s))
        back_ms = unix_ms(time.monotonic())
        await self._ip("address", "add", f"{new}/24", "dev", DEVICE)
        await self._ip("route", "replace", "default", "dev", DEVICE)
        return back_ms

    async def press(self) -> bool:
        """Hold the key, and press again while the robot does not move; tell whether it does."""
        for _ in range(_PRESSES):
            await self.viewer.page.keyboard.up(_KEY)
            await asyncio.sleep(_LET_GO_S)
            await self.viewer.page.keyboard.down(_KEY)
            if await moves(self._server):
                return True
        return False

    async def needs_a_new_press(self) -> bool:
        """Tell whether the key that is still held moves nothing, and one that is pressed does."""
        return not await moves(self._server, within_s=_STILL_S) and await self.press()

    async def back_after(self, fault: Fault) -> float | None:
        """Return how many ms after the fault's end the picture was back; None for never."""
        back_ms = await fault()
        try:
            async with asyncio.timeout(_BACK_WITHIN_S):
                return float(await self.viewer.probe(f"sees({back_ms})")) - back_ms
        except TimeoutError:
            return None

    async def _ip(self, *arguments: str) -> None:
        code = await (await self._link.browser.spawn(["ip", *arguments])).wait()
        if code:
            raise MeasureError(f"ip {' '.join(arguments)} ended with status {code}")


@asynccontextmanager
async def _driving(outages: int) -> AsyncIterator[Driving]:
    """Serve, and let somebody drive; `black_hole` can be called so often."""
    # Of random length, so that the end meets the page's attempts at every phase.
    begins_s = [index * _SLOT_S + 0.1 for index in range(outages)]
    outages_s = [(at_s, at_s + OUTAGE_S + random.random()) for at_s in begins_s]
    async with AsyncExitStack() as opening:
        folder = Path(opening.enter_context(tempfile.TemporaryDirectory(prefix="wax-")))
        settings = _SETTINGS | {"server": _SERVER | {"state_dir": str(folder / "state")}}
        link = await opening.enter_async_context(Link(_with_outages(load(_NETWORK), outages_s)))
        served = await opening.enter_async_context(
            serving(link.server, folder, tomlkit.dumps(settings))
        )
        playwright = await opening.enter_async_context(async_playwright())
        known = [link.server.address]
        browser = await opening.enter_async_context(chromium_at(link.browser, playwright, known))
        # Without any permission, as strangers have it.
        viewer = await Viewer.at(await browser.new_context(), served.url)
        await viewer.sees_picture()
        await viewer.takes_the_wheel()
        await served.become_host(folder / "state")
        yield Driving(link, served, folder / "wax.log", viewer, outages_s)


FAULTS: Final = {
    "outage": f"{OUTAGE_S:g} to 6 s without a packet",
    "network": "another network",
    "absence": "another network after 2 to 3 s without any",
}


async def reconnect(key: str, n: int) -> list[Row]:
    """Lose the link `n` times in one way.

    A turn that is lost misses the goal, and a robot that moves by what was held through it.
    """
    took_ms: list[float | None] = []
    wrong = 0
    async with _driving(n if key == "outage" else 0) as driving:
        fault = (
            driving.black_hole
            if key == "outage"
            else partial(driving.other_network, _WITHOUT_S[key])
        )
        if not await driving.press():
            raise MeasureError("a key that is held in the page does not move the robot")
        for _ in range(n):
            await asyncio.sleep(random.uniform(*_SETTLE_S))
            before = driving.turns()
            took_ms.append(await driving.back_after(fault))
            kept = await driving.drives_again()
            kept = kept and driving.turns() == before
            wrong += not (await driving.needs_a_new_press() and kept)
    return [
        summed(
            f"reconnect-{key}: {judged}",
            f"{FAULTS[key]}: link back → new picture on screen, in the same turn, {judged}",
            "ms",
            took_ms,
            goal_ms,
            judged=judged,
            wrong=wrong,
        )
        for judged, goal_ms in zip(("median", "p95"), GOALS_MS[key], strict=True)
    ]


def _with_outages(profile: Profile, outages_s: Sequence[tuple[float, float]]) -> Profile:
    """Let every packet be lost, both ways, during each of these."""

    def cut(way: DirectionSettings) -> DirectionSettings:
        changes = [
            change
            for begin_s, end_s in outages_s
            for change in (
                Change(at_s=begin_s, loss=Loss(in_good=1.0)),
                Change(at_s=end_s, loss=way.loss),
            )
        ]
        return way.model_copy(update={"changes": changes})

    return profile.model_copy(update={"down": cut(profile.down), "up": cut(profile.up)})
