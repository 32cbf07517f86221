"""WAX itself, started as a person starts it, with the policy that the cell names."""

from __future__ import annotations

from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any, Final

import tomlkit

from e2e.delay.systems import served
from e2e.delay.systems.served import STATE, Served
from e2e.delay.systems.settings import settings
from e2e.harness.robot import key_moves
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


class Wax(Served):
    """Its page is the operator's if it `joins`, and holds a key all the time if it `drives`."""

    joins = drives = False

    async def opened(self, window: Page) -> None:
        await window.evaluate(press("Turn sound on"))
        if not self.joins:
            return
        await self._until(window, press("Join the queue"), "lets one join the queue")
        await self._until(window, says("You are driving"), "says that the browser drives")
        how = (window, "ArrowUp", DRIVES_WITHIN_S)
        if self.drives and not await key_moves(self, *how, if_late=True):
            raise MeasureError("a key that is held in the page of WAX does not move the robot")

    async def fail_safe_s(self) -> float | None:
        viewers = sorted((await self.status())["viewers"], key=lambda line: line["id"])
        streams: dict[str, Any] = viewers[0].get("streams") or {} if viewers else {}
        return streams.get("fail_safe_s")

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
    """See `e2e.delay.systems.start`; `more` are tables in addition to the cell's."""
    config = tomlkit.dumps(merged(settings(cell), more))
    async with serving(link.server, folder, config, variables=variables) as wax:
        wax.joins, wax.drives = cell.system == "operator", cell.drives
        await wax.become_host(folder / STATE / "wax")
        yield wax
