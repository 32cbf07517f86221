"""WAX itself, started as a person starts it, with whichever policy the cell asks for."""

from __future__ import annotations

import asyncio
import time
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any, Final

import tomlkit

from e2e.delay.systems.running import Running
from e2e.delay.systems.served import STATE, Served, serving
from e2e.delay.systems.settings import settings
from e2e.harness.wait import eventually
from e2e.measure.errors import MeasureError

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Mapping
    from pathlib import Path

    from playwright.async_api import Page

    from e2e.delay.cell import Cell
    from e2e.link import Link

DRIVES_WITHIN_S: Final = 30.0
_MOVES_WITHIN_S: Final = 1.0
_LET_GO_S: Final = 0.3
"""In which the page says several times that nothing is held."""
_LOOK_EVERY_S: Final = 0.1


class Wax(Running):
    def __init__(self, served: Served, *, joins: bool, drives: bool = False) -> None:
        super().__init__(served)
        self._joins = joins
        self._drives = drives

    async def opened(self, window: Page) -> None:
        await window.evaluate(press("Turn sound on"))
        if not self._joins:
            return
        before = await self._disturbances()
        await self._until(window, press("Join the queue"), "lets one join the queue")
        says = "document.body.innerText.includes('You are driving')"
        await self._until(window, says, "says that the browser drives")
        if self._drives:
            await self._drive(window, before)

    async def told(self) -> dict[str, float | str]:
        status = await self._served.json("/api/status")
        first, *_ = sorted(status.pop("viewers"), key=lambda line: line["id"]) or [{}]
        return flat(status) | flat({"viewer": first})

    async def _drive(self, window: Page, before: float) -> None:
        """Hold a key; press it again if the server requires it.

        It does while the page sees no picture yet, and after it was late itself: a key that is
        held through that moves nothing (`wax.control.gate`).
        """
        until_s = time.monotonic() + DRIVES_WITHIN_S
        while time.monotonic() < until_s:
            await window.keyboard.down("ArrowUp")
            if await self._moves():
                return
            now = await self._disturbances()
            if now == before:
                break
            before = now
            await window.keyboard.up("ArrowUp")
            await asyncio.sleep(_LET_GO_S)
        raise MeasureError("a key that is held in the page of WAX does not move the robot")

    async def _moves(self) -> bool:
        until_s = time.monotonic() + _MOVES_WITHIN_S
        while time.monotonic() < until_s:
            if (await self.told())["robot.speed_mps"] != 0:
                return True
            await asyncio.sleep(_LOOK_EVERY_S)
        return False

    async def _disturbances(self) -> float:
        """Count how often the server was late itself, or refused what the page said."""
        told = await self.told()
        return sum(
            float(count)
            for name, count in told.items()
            if name == "counters.control.late" or name.startswith("counters.commands.refused.")
        )

    async def _until(self, window: Page, expression: str, what: str) -> None:
        async def is_so() -> bool:
            self._served.check()
            return bool(await window.evaluate(expression))

        await eventually(is_so, f"the page of WAX {what}", within_s=DRIVES_WITHIN_S)


@asynccontextmanager
async def start(cell: Cell, link: Link, folder: Path) -> AsyncIterator[Wax]:
    """See `e2e.delay.systems.start`."""
    config = folder / "wax.toml"
    config.write_text(tomlkit.dumps(settings(cell)), encoding="utf-8")
    async with serving(
        "wax", link.server, folder, ["-m", "wax", "--config", str(config)]
    ) as served:
        await served.become_host(folder / STATE / "wax")
        yield Wax(served, joins=cell.system == "operator", drives=cell.drives)


def flat(tree: Mapping[str, Any], prefix: str = "") -> dict[str, float | str]:
    """Return the numbers and texts of a tree with dotted names; lists and nulls are left out."""
    found: dict[str, float | str] = {}
    for name, value in tree.items():
        match value:
            case dict():
                found |= flat(value, f"{prefix}{name}.")
            case int() | float():  # truth values too, as 1 and 0
                found[prefix + name] = float(value)
            case str():
                found[prefix + name] = value
    return found


def press(name: str) -> str:
    """Return a script that presses the button with this text, and is true when there is one."""
    return (
        "((button) => Boolean(button && !button.disabled && (button.click(), true)))"
        f"({_button(name)})"
    )


def has(name: str) -> str:
    """Return an expression that is true once there is a button with this text."""
    return f"Boolean({_button(name)})"


def _button(name: str) -> str:
    return (
        "[...document.querySelectorAll('button')].find((one) => "
        f"(one.getAttribute('aria-label') ?? one.textContent).trim() === '{name}')"
    )
