"""The robot's pose as the server reports it, and whether it moves."""

from __future__ import annotations

import asyncio
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer

T = TypeVar("T")

STILL_M = 0.002
STILL_RAD = 0.004


class Told(Protocol):
    """A server that says how it and its robot are."""

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

    def turned_rad(self, since: Pose) -> float:
        """Counter-clockwise, -pi…pi."""
        turn = self.heading_rad - since.heading_rad
        return math.atan2(math.sin(turn), math.cos(turn))


async def pose(server: Told) -> Pose:
    robot = (await server.status())["robot"]
    return Pose(**robot["pose"])


async def moves(server: Server, during_s: float = 0.5) -> bool:
    before = await pose(server)
    await asyncio.sleep(during_s)
    return (await pose(server)).moved(before)


async def lateness(server: Told) -> int:
    """Count how often the server was late, or got commands late, and required a new press."""
    counters = (await server.status())["counters"]
    return sum(
        count
        for name, count in counters.items()
        if name == "control.late" or name.startswith("commands.refused.")
    )


async def undisturbed(server: Server, attempt: Callable[[], Awaitable[T]]) -> T:
    """Do `attempt`, up to three times while the server is too late."""
    before = await lateness(server)
    result = await attempt()
    for _ in range(2):
        now = await lateness(server)
        if now == before:
            break
        before = now
        result = await attempt()
    return result


async def holding_moves(
    server: Server,
    press: Callable[[], Awaitable[None]],
    let_go: Callable[[], Awaitable[None]],
    during_s: float,
) -> bool:
    """Return whether the robot moves while it is held on; let go, it stands."""

    async def attempt() -> bool:
        await press()
        moved = await moves(server, during_s)
        await let_go()
        assert await stands_still(server)
        return moved

    return await undisturbed(server, attempt)


async def nothing_is_held(server: Server) -> None:
    """Wait until the operator's page has said so, without which no press moves anything."""

    def accepted(status: dict[str, Any]) -> int:
        return int(status["counters"].get("commands.accepted", 0))

    before = accepted(await server.status())
    await server.until(lambda told: accepted(told) > before, "the page says that nothing is held")


async def until_it_moves(
    server: Server,
    press: Callable[[], Awaitable[None]],
    let_go: Callable[[], Awaitable[None]],
    is_moving: Callable[[], Awaitable[bool]] | None = None,
) -> None:
    """Hold on until the robot moves; press again if a busy machine requires it."""
    for _ in range(3):
        await nothing_is_held(server)
        before = await lateness(server)
        await press()
        if await (moves(server) if is_moving is None else is_moving()):
            return
        await let_go()
        if await lateness(server) == before:
            break
    raise AssertionError("the robot stands while it is driven")


async def turn_by_key(server: Server, viewer: Viewer) -> None:
    keys = viewer.page.keyboard
    await until_it_moves(server, lambda: keys.down("ArrowLeft"), lambda: keys.up("ArrowLeft"))


async def stands_still(server: Server, after_s: float = 0.5) -> bool:
    """Return whether the robot stands `after_s` from now and stays so for a while."""
    await asyncio.sleep(after_s)
    return not await moves(server, during_s=0.6)
