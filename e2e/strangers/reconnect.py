"""How soon after the link picture and sound are back, in the same turn, with the robot standing.

The link is lost in two ways: every packet is dropped for five seconds, without any event; or the
browser's machine gets another address, at once or after some time without any, like a phone that
leaves the house. A key is held all the time, and the page may always use the microphone.
"""

from __future__ import annotations

import asyncio
import random
import tempfile
import time
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from functools import partial
from ipaddress import IPv4Address
from pathlib import Path
from typing import TYPE_CHECKING, Final

import tomlkit
from playwright.async_api import async_playwright
from tests.link.profile import Change, Loss, load

from e2e.delay.systems.served import PORT, origin
from e2e.delay.systems.wax import serving
from e2e.harness.chromium import at_end, talkers_chromium
from e2e.harness.page_clock import unix_ms
from e2e.harness.robot import key_moves, stands_still
from e2e.harness.toml import MEDIA
from e2e.harness.viewer import Viewer
from e2e.harness.wait import eventually
from e2e.link import Link
from e2e.link.namespace import BROWSER_ADDRESS, DEVICE
from e2e.measure.ear import SILENT, open_ear
from e2e.measure.errors import MeasureError
from e2e.measure.row import Row, summed

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable, Iterable, Iterator, Sequence

    from tests.link.profile import DirectionSettings, Profile

    from e2e.delay.systems.wax import Wax
    from e2e.measure.ear import Block

    Fault = Callable[[], Awaitable[float]]

OUTAGE_S: Final = 5.0
SOUND_GOAL_MS: Final = 900.0
"""The goal of the median."""
PAUSE_GOAL_MS: Final = 500.0
_PAUSES_WITHIN_S: Final = 5.0
"""For so long after the first picture no further pause may be longer than the goal."""

_NETWORK: Final = "internet-5m"
_WITHOUT_S: Final = {"network": (0.0, 1.0), "absence": (2.0, 3.0)}
"""Between the old address and the new one, as when a phone changes or looks for a network."""
_KEY: Final = "ArrowLeft"
_MOVES_WITHIN_S: Final = 6.0
_BACK_WITHIN_S: Final = 12.0
_PAUSE_MS: Final = 50.0
"""A shorter silence does not count as an interruption."""
_DRIVES_WITHIN_S: Final = 15.0
_SLOT_S: Final = 18.0
"""From one outage to the next: the longest outage, time to settle, and a late return."""
_SETTLE_S: Final = (3.0, 4.0)
"""From a picture to the next fault: steady again, and at a random phase of every timer."""

_SERVER: Final = {"host": "0.0.0.0", "port": PORT}
_SETTINGS: Final = {**MEDIA, "turns": {"turn_s": 3600.0}}


@dataclass
class Driving:
    """A browser that drives, behind a link that can be cut at `outages_s` after its start."""

    link: Link
    server: Wax
    log: Path
    viewer: Viewer
    outages_s: Iterator[tuple[float, float]]
    address: str = BROWSER_ADDRESS
    began_s: float | None = None

    def turns(self) -> int:
        """Count the turns that have started, by the server's log."""
        return self.log.read_text(encoding="utf-8").count("TurnStarted")

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
        """Drop every packet for a while; return when that ended, in Unix milliseconds."""
        if self.began_s is None:
            self.began_s = await self.link.start_changes()
        begin_s, end_s = (self.began_s + at_s for at_s in next(self.outages_s))
        if begin_s < time.monotonic():
            raise MeasureError("the page came back too late for the next outage")
        await asyncio.sleep(end_s - time.monotonic())
        return unix_ms(end_s)

    async def other_network(self, without_s: tuple[float, float]) -> float:
        """Give the browser's machine another address after `without_s` without any; return when.

        It has never had that one: the server goes on at once at an address that it has checked.
        """
        await self._ip("address", "del", f"{self.address}/24", "dev", DEVICE)
        self.address = str(IPv4Address(self.address) + 1)
        await asyncio.sleep(random.uniform(*without_s))
        back_ms = unix_ms(time.monotonic())
        await self._ip("address", "add", f"{self.address}/24", "dev", DEVICE)
        await self._ip("route", "replace", "default", "dev", DEVICE)
        return back_ms

    async def press(self) -> bool:
        """Hold the key, pressing again until the robot moves; return whether it does."""
        return await key_moves(self.server, self.viewer.page, _KEY, _MOVES_WITHIN_S)

    async def longest_pause_ms(self) -> float:
        """Watch the pictures for a while; return the longest time without a new one."""
        return float(await self.viewer.probe(f"longestPause({_PAUSES_WITHIN_S * 1000})"))

    async def goes_on(self, turns: int) -> bool:
        """Return whether the turn, the last of so many, lasts, and the robot asks for a press."""
        kept = await self.drives_again()
        kept = kept and self.turns() == turns
        return await self.needs_a_new_press() and kept

    async def needs_a_new_press(self) -> bool:
        """Return whether the key still held moves nothing, and a new press moves the robot."""
        return await stands_still(self.server) and await self.press()

    async def back_after(self, fault: Fault) -> tuple[float, float | None]:
        """Return when the fault ended, and after how many ms the picture was back (None: never).

        The first is Unix time in ms.
        """
        back_ms = await fault()
        try:
            async with asyncio.timeout(_BACK_WITHIN_S):
                return back_ms, float(await self.viewer.probe(f"sees({back_ms})")) - back_ms
        except TimeoutError:
            return back_ms, None

    async def _ip(self, *arguments: str) -> None:
        code = await (await self.link.browser.spawn(["ip", *arguments])).wait()
        if code:
            raise MeasureError(f"ip {' '.join(arguments)} ended with status {code}")


@asynccontextmanager
async def _driving(outages: int) -> AsyncIterator[Driving]:
    """Serve, and let somebody drive; `black_hole` can be called `outages` times."""
    # Their length is random, so that they end at every phase of the page's attempts.
    begins_s = [index * _SLOT_S + 0.1 for index in range(outages)]
    outages_s = [(at_s, at_s + OUTAGE_S + random.random()) for at_s in begins_s]
    async with AsyncExitStack() as opening:
        folder = Path(opening.enter_context(tempfile.TemporaryDirectory(prefix="wax-")))
        settings = _SETTINGS | {"server": _SERVER | {"state_dir": str(folder / "state")}}
        link = await opening.enter_async_context(Link(_with_outages(load(_NETWORK), outages_s)))
        served = await opening.enter_async_context(
            serving(link.server, folder, tomlkit.dumps(settings))
        )
        ear = await opening.enter_async_context(open_ear())
        playwright = await opening.enter_async_context(async_playwright())
        flags, options = opening.enter_context(at_end(link.browser, [link.server.address]))
        secure = f"--unsafely-treat-insecure-origin-as-secure={origin(link)}"
        context = await opening.enter_async_context(
            talkers_chromium(playwright, origin(link), secure, *flags, ear=ear, **options)
        )
        viewer = await Viewer.at(context, served.url, ear)
        await viewer.sees_picture()
        await viewer.listen()
        await viewer.takes_the_wheel()
        await served.become_host(folder / "state")
        yield Driving(link, served, folder / "wax.log", viewer, iter(outages_s))


FAULTS: Final = {
    "outage": (f"{OUTAGE_S:g} to 6 s without a packet", 1200.0, 2000.0),
    "network": ("another network", 300.0, 1200.0),
    "absence": ("another network after 2 to 3 s without any", 300.0, 1200.0),
}
"""Each with its goals in ms, for the median and the 95th percentile."""


async def reconnect(keys: Sequence[str], n: int) -> list[Row]:
    """Lose the link `n` times in each of these ways, in turn.

    A lost turn misses the goal, and so does a robot that is moved by the key held through the loss.
    """
    pictures_ms: dict[str, list[float | None]] = {key: [] for key in keys}
    sounds_ms: list[float | None] = []
    pauses_ms: list[float] = []
    wrong = dict.fromkeys(keys, 0)
    async with _driving(n if "outage" in keys else 0) as driving:
        if not await driving.press():
            raise MeasureError("a key that is held in the page does not move the robot")
        for key in [*keys] * n:
            fault = (
                driving.black_hole
                if key == "outage"
                else partial(driving.other_network, _WITHOUT_S[key])
            )
            driving.viewer.forget()
            await asyncio.sleep(random.uniform(*_SETTLE_S))
            before = driving.turns()
            back_ms, took_ms = await driving.back_after(fault)
            pause_ms, is_right = await asyncio.gather(
                driving.longest_pause_ms(), driving.goes_on(before)
            )
            wrong[key] += not is_right
            pictures_ms[key].append(took_ms)
            pauses_ms.append(pause_ms)
            sounds_ms.append(heard_after(driving.viewer.heard(), back_ms))
    rows = [_picture(key, pictures_ms[key], wrong[key]) for key in keys]
    if "outage" in keys:
        return rows
    network, key = "another network, at once or after a while", f"reconnect-{keys[0]}"
    what = f"{network}: link back → sound goes on"
    sound = summed(f"{key}: sound", what, "ms", sounds_ms, SOUND_GOAL_MS, judged="median")
    what = f"{network}: longest pause in the {_PAUSES_WITHIN_S:g} s after the new picture"
    return [*rows, sound, summed(f"{key}: pause", what, "ms", pauses_ms, PAUSE_GOAL_MS)]


def _picture(key: str, took_ms: Sequence[float | None], wrong: int) -> Row:
    what, goal_ms, p95_goal_ms = FAULTS[key]
    row = summed(
        f"reconnect-{key}: median",
        f"{what}: link back → new picture on screen, in the same turn; p95 ≤ {p95_goal_ms:g} ms",
        "ms",
        took_ms,
        goal_ms,
        judged="median",
        wrong=wrong,
    )
    p95_ms = row.values.get("p95")
    is_late = p95_ms is None or p95_ms > p95_goal_ms
    return row.model_copy(update={"met": row.met and not is_late})


def heard_after(blocks: Iterable[Block], back_ms: float) -> float | None:
    """Return how many ms after `back_ms` the silence of a lost link ended.

    0 if there was none, or it had ended before; None if it has not ended.
    """
    since_ms: float | None = None
    lasted_ms = 0.0
    for block in blocks:
        lasted_ms = 0.0 if since_ms is None else block.start_ms - since_ms
        if block.rms <= SILENT:
            since_ms = block.start_ms if since_ms is None else since_ms
            continue
        if lasted_ms >= _PAUSE_MS and block.start_ms > back_ms:
            return block.start_ms - back_ms
        since_ms, lasted_ms = None, 0.0
    return None if lasted_ms >= _PAUSE_MS else 0.0


def _with_outages(profile: Profile, outages_s: Sequence[tuple[float, float]]) -> Profile:
    """Drop every packet, both ways, during each of these outages."""

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
