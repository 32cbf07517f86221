"""WAX itself, started as a person starts it, with whichever policy the cell asks for."""

from __future__ import annotations

import asyncio
import time
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any, Final

import tomlkit

from e2e.delay.systems import served
from e2e.delay.systems.served import STATE, Served
from e2e.delay.systems.settings import settings
from e2e.harness.robot import lateness, moves
from e2e.harness.scripts import press, says
from e2e.harness.toml import merged
from e2e.harness.wait import eventually
from e2e.measure.errors import MeasureError

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Mapping
    from contextlib import AbstractAsyncContextManager
    from pathlib import Path

    from playwright.async_api import Page

    from e2e.delay.cell import Cell
    from e2e.link import End, Link

DRIVES_WITHIN_S: Final = 30.0
_MOVES_WITHIN_S: Final = 1.0
_LET_GO_S: Final = 0.3
"""In which the page says several times that nothing is held."""


class Wax(Served):
    """Its page is the operator's where it `joins`, and holds a key all the time if it `drives`."""

    joins = drives = False

    async def status(self) -> dict[str, Any]:
        """Return what it says of itself, once this is its host."""
        told: dict[str, Any] = await self.json("/api/status")
        return told

    async def opened(self, window: Page) -> None:
        await window.evaluate(press("Turn sound on"))
        if not self.joins:
            return
        before = await lateness(self)
        await self._until(window, press("Join the queue"), "lets one join the queue")
        await self._until(window, says("You are driving"), "says that the browser drives")
        if self.drives:
            await self._drive(window, before)

    async def fail_safe_s(self) -> float | None:
        viewers = sorted((await self.status())["viewers"], key=lambda line: line["id"])
        streams: dict[str, Any] = viewers[0].get("streams") or {} if viewers else {}
        return streams.get("fail_safe_s")

    async def _drive(self, window: Page, before: int) -> None:
        """Hold a key; press it again if the server requires it.

        It does while the page sees no picture yet, and after it was late itself: a key that is
        held through that moves nothing (`wax.control.gate`).
        """
        until_s = time.monotonic() + DRIVES_WITHIN_S
        while time.monotonic() < until_s:
            await window.keyboard.down("ArrowUp")
            if await moves(self, within_s=_MOVES_WITHIN_S):
                return
            now = await lateness(self)
            if now == before:
                break
            before = now
            await window.keyboard.up("ArrowUp")
            await asyncio.sleep(_LET_GO_S)
        raise MeasureError("a key that is held in the page of WAX does not move the robot")

    async def _until(self, window: Page, expression: str, what: str) -> None:
        async def is_so() -> bool:
            self.check()
            return bool(await window.evaluate(expression))

        await eventually(is_so, f"the page of WAX {what}", within_s=DRIVES_WITHIN_S)


def serving(
    end: End, folder: Path, config: str, *words: str, variables: Mapping[str, str] | None = None
) -> AbstractAsyncContextManager[Wax]:
    """Serve with this configuration; see `e2e.delay.systems.served.serving`."""
    path = folder / "wax.toml"
    path.write_text(config, encoding="utf-8")
    arguments = ["-m", "wax", "--config", str(path), *words]
    return served.serving(Wax, "wax", end, folder, arguments, variables=variables)


@asynccontextmanager
async def start(
    cell: Cell, link: Link, folder: Path, variables: Mapping[str, str] | None = None, **more: Any
) -> AsyncIterator[Wax]:
    """See `e2e.delay.systems.start`; `more` are tables beside the cell's."""
    config = tomlkit.dumps(merged(settings(cell), more))
    async with serving(link.server, folder, config, variables=variables) as wax:
        wax.joins, wax.drives = cell.system == "operator", cell.drives
        await wax.become_host(folder / STATE / "wax")
        yield wax
