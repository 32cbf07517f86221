"""The robot's pose as the server reports it, and whether it moves."""

from __future__ import annotations

import asyncio
import math
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Protocol, TypeVar

from e2e.harness.wait import happens

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from playwright.async_api import Page

    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer

T = TypeVar("T")

STILL_M: Final = 0.002
STILL_RAD: Final = 0.004
STANDS_WITHIN_S: Final = 0.5
"""Includes the braking distance; `e2e.stop` measures how late each part of a stop is."""
_LATE: Final = (
    "control.late",
    "commands.lapsed",
    *(f"commands.refused.{why}" for why in ("too_old", "too_slow", "from_future", "blind", "lost")),
    *(f"controls.refused.{why}" for why in ("too_old", "too_slow", "from_future")),
    *(f"driver_{why}" for why in ("silences", "stale", "unarmed")),
)
"""The server's counts of its own, its driver's process's or a page's lateness, after which the
robot stands or even needs a new press. A driver in the server's own process has no counts."""
_TRIES: Final = 3
_LET_GO_S: Final = 0.3
"""In this time a page says several times that nothing is held."""


class Told(Protocol):
    """A server that reports its own state and its robot's."""

    async def status(self) -> dict[str, Any]: ...


@dataclass(frozen=True, slots=True)
class Pose:
    x_m: float
    y_m: float
    heading_rad: float

    def moved(self, since: Pose) -> bool:
        """Return whether it differs by more than the noise of reading it."""
        return self.distance_m(since) > STILL_M or abs(self.turned_rad(since)) > STILL_RAD

    def distance_m(self, since: Pose) -> float:
        return math.hypot(self.x_m - since.x_m, self.y_m - since.y_m)

    def ahead_m(self, since: Pose) -> float:
        """Return the distance towards where the robot looked then; negative is back."""
        east_m, north_m = self.x_m - since.x_m, self.y_m - since.y_m
        return east_m * math.cos(since.heading_rad) + north_m * math.sin(since.heading_rad)

    def left_m(self, since: Pose) -> float:
        """Return the distance to the left of where the robot looked then; negative is right."""
        aside = Pose(since.x_m, since.y_m, since.heading_rad + math.pi / 2)
        return self.ahead_m(aside)

    def turned_rad(self, since: Pose) -> float:
        """Return the turn since then, counter-clockwise, -pi…pi."""
        turn = self.heading_rad - since.heading_rad
        return math.atan2(math.sin(turn), math.cos(turn))


async def pose(server: Told) -> Pose:
    robot = (await server.status())["robot"]
    return Pose(**robot["pose"])


async def moves(server: Told, within_s: float = 2.0) -> bool:
    """Return whether the robot moves, as soon as it does; False after `within_s`."""
    before = await pose(server)

    async def has_moved() -> bool:
        return (await pose(server)).moved(before)

    return await happens(has_moved, within_s=within_s)


async def drives_on(server: Server) -> bool:
    """Return whether a robot that has moved still moves, after the time that braking takes."""
    await asyncio.sleep(0.3)
    return await moves(server, within_s=0.5)


async def lateness(server: Told) -> int:
    """Return how often somebody was too late, so that the robot rightly stood or wants a press."""
    status = await server.status()
    counts = status["robot"] | status["counters"]
    return sum(int(counts.get(name, 0)) for name in _LATE)


async def undisturbed(
    server: Server, attempt: Callable[[], Awaitable[T]], connections: Callable[[], int] = int
) -> T:
    """Run `attempt` with nothing held; again, if it failed while somebody was too late.

    `connections` counts the robot's connections, each of which wants a new press as well.
    """
    for _ in range(_TRIES - 1):
        before = await lateness(server) + connections()
        await nothing_is_held(server)
        if result := await attempt():
            return result
        await nothing_is_held(server)  # by then the driver's process has also reported its counts
        if await lateness(server) + connections() == before:
            return result
    await nothing_is_held(server)
    return await attempt()


async def holding_moves(
    server: Server, press: Callable[[], Awaitable[None]], let_go: Callable[[], Awaitable[None]]
) -> bool:
    """Hold on and return whether the robot moves; after release it stands."""

    async def attempt() -> bool:
        await press()
        moved = await moves(server)
        await let_go()
        assert await stands_still(server)
        return moved

    return await undisturbed(server, attempt)


async def nothing_is_held(server: Server) -> None:
    """Wait until the operator's page reports that nothing is held: only then can a press count."""

    def accepted(status: dict[str, Any]) -> int:
        return int(status["counters"].get("commands.accepted", 0))

    before = accepted(await server.status())
    await server.until(  # the first may have been sent before the release
        lambda told: accepted(told) > before + 1, "the page says that nothing is held", every_s=0.02
    )


async def until_it_moves(
    server: Server,
    press: Callable[[], Awaitable[None]],
    let_go: Callable[[], Awaitable[None]],
    is_moving: Callable[[], Awaitable[bool]] | None = None,
    connections: Callable[[], int] = int,
) -> None:
    """Hold on until the robot moves; press again if a busy machine requires it."""

    async def moves_on() -> bool:
        await press()
        if await (moves(server) if is_moving is None else is_moving()):
            return True
        await let_go()
        return False

    assert await undisturbed(server, moves_on, connections), "the robot stands while it is driven"


async def key_moves(
    server: Told, page: Page, key: str, within_s: float, *, if_late: bool = False
) -> bool:
    """Hold a key, and press again while the robot stands; return whether it moves in time.

    A key held before the page sees a picture, or while it was late, moves nothing (`control.gate`).
    With `if_late` it is pressed again only where the server says so.
    """
    until_s, before, late = time.monotonic() + within_s, -1, await lateness(server)
    while time.monotonic() < until_s and not (if_late and late == before):
        before = late
        await page.keyboard.up(key)
        await asyncio.sleep(_LET_GO_S)
        await page.keyboard.down(key)
        if await moves(server):
            return True
        late = await lateness(server)
    return False


async def turn_by_key(server: Server, viewer: Viewer, key: str = "ArrowLeft") -> None:
    keys = viewer.page.keyboard
    await until_it_moves(server, lambda: keys.down(key), lambda: keys.up(key))


async def stands_still(server: Told, after_s: float = STANDS_WITHIN_S, for_s: float = 0.6) -> bool:
    """Return whether the robot stands within `after_s`, and stays so for `for_s`.

    Commands come at least 10 times a second, so anything that would move it on does so at once.
    """
    late_s = time.monotonic() + after_s
    asked_s, at = time.monotonic(), await pose(server)
    stood_s = asked_s
    while asked_s < stood_s + for_s:
        await asyncio.sleep(0.05)
        before_s, asked_s = asked_s, time.monotonic()
        now = await pose(server)
        if now.moved(at):
            if before_s > late_s:
                return False
            stood_s, at = asked_s, now
    return True
