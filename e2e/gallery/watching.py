"""States of joining, watching, waiting, and being called."""

from __future__ import annotations

import asyncio
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Final

from e2e.harness.wait import eventually
from wax.config.opening_hours import DAYS

if TYPE_CHECKING:
    from e2e.gallery.scene import Scene

_READY_S: Final = 20.0
_TURN_S: Final = 3.0
_REST_S: Final = 90.0
_NAME: Final = "http://robot.example"
"""An address for visitors, to which the screen's code leads; here it is the server's own."""


async def connecting(scene: Scene) -> None:
    """Open the page while its requests to the server get lost."""
    viewer = await scene.prepares()
    await scene.loses("**/api/offer")
    await viewer.page.goto(scene.server.url)


async def somebody_drives(scene: Scene) -> None:
    await scene.somebody_drives()
    await scene.comes("Bob")
    await scene.opens()


async def waiting(scene: Scene) -> None:
    await scene.somebody_drives()
    await scene.somebody_waits()
    viewer = await scene.opens()
    await viewer.join()


async def you_are_next(scene: Scene) -> None:
    await scene.somebody_drives()
    viewer = await scene.opens()
    await viewer.join()


async def called(scene: Scene) -> None:
    """Ask somebody who has been idle for a while whether they are there: the robot is free."""
    await scene.serves(turns={"ready_s": _READY_S})
    operator = await scene.somebody_drives()
    viewer = await scene.opens()
    await viewer.join()
    await asyncio.sleep(_READY_S + 0.5)
    await operator.leave()


async def turn_over(scene: Scene) -> None:
    """End the viewer's turn because somebody else waits; others go first for a while."""
    await scene.serves(turns={"turn_s": _TURN_S, "cooldown_s": _REST_S})
    viewer = await scene.drives()
    other = await scene.somebody_waits("Ada")
    await asyncio.sleep(_TURN_S)
    await other.gets_turn()

    async def is_over() -> bool:
        return not await viewer.page.get_by_text("You are driving").first.is_visible()

    await eventually(is_over, "the page says that the turn is over")


async def full(scene: Scene) -> None:
    """Join when the only place is taken."""
    await scene.serves(server={"max_viewers": 1})
    await scene.comes("Ada")
    viewer = await scene.prepares()
    await viewer.page.goto(scene.server.url)


async def removed(scene: Scene) -> None:
    host = await scene.comes("Host", is_host=True)
    await scene.opens()

    def guests() -> list[int]:
        viewers = host.newest("room").get("viewers", [])
        return [one["id"] for one in viewers if one["id"] != host.viewer]

    assert await host.until(lambda: bool(guests()), 20), "the host sees no guest"
    host.send(type="remove", viewer=guests()[0], ban=False)


async def closed(scene: Scene) -> None:
    """Come on a weekday on which the robot is closed."""
    today = datetime.now(UTC).weekday()
    first, last = (DAYS[(today + later) % len(DAYS)] for later in (2, 5))
    hours = [f"{first}-{last} 09:00-18:00", f"{last} 20:00-01:00"]
    await scene.serves(access={"hours": hours})
    viewer = await scene.prepares()
    await viewer.page.goto(scene.server.url)


async def big_screen(scene: Scene) -> None:
    """Show the robot on a screen in a hall, while somebody drives."""
    await scene.somebody_drives()
    viewer = await scene.prepares()
    await viewer.is_reached_as(_NAME)
    await viewer.page.goto(f"{_NAME}/?view=big-screen")
    await viewer.sees_picture()


async def embed(scene: Scene) -> None:
    """Show only the frame on another site, while somebody drives and somebody waits."""
    await scene.somebody_drives()
    await scene.somebody_waits()
    await scene.opens("/?view=embed")


async def glass(scene: Scene) -> None:
    """Measure the delay with camera and screen while the camera sees no code."""
    viewer = await scene.opens("/?view=glass")
    await viewer.page.get_by_text("no code in the picture").wait_for()
