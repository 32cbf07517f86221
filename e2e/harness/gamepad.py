"""A gamepad in a page, found as a real one is: by `navigator.getGamepads` and events."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from playwright.async_api import Page

B: Final = 1
START: Final = 9
LEFT_OF_CROSS: Final = 14
"""Buttons of the standard layout (W3C Gamepad)."""

SCRIPT: Final = Path(__file__).with_name("gamepad.js").read_text(encoding="utf-8")
SEEN: Final = "() => new Promise((seen) => setTimeout(seen, 100))"
"""A page looks at gamepads each 50 ms; by its own timers, which a busy machine delays alike."""


class InjectedGamepad:
    """One standard gamepad, in the place of all that the browser knows."""

    def __init__(self, page: Page) -> None:
        self._page = page

    @classmethod
    async def plugged_in(cls, page: Page) -> InjectedGamepad:
        await page.evaluate(SCRIPT)
        await page.evaluate("() => waxPad.plug()")
        return cls(page)

    async def push(self, axis: int, value: float) -> None:
        """Push a stick: axis 0 is left to right, axis 1 ahead (-1) to back."""
        await self._page.evaluate("([axis, value]) => waxPad.push(axis, value)", [axis, value])

    async def is_seen(self) -> None:
        """Wait until the page has looked at it again."""
        await self._page.evaluate(SEEN)

    async def press(self, button: int, *, on: bool = True) -> None:
        await self._page.evaluate("([button, on]) => waxPad.press(button, on)", [button, on])

    async def tap(self, button: int) -> None:
        """Press a button, and let go of it once the page has seen that."""
        await self.press(button)
        await self.is_seen()
        await self.press(button, on=False)
        await self.is_seen()

    async def unplug(self) -> None:
        """Take it away, without the browser's event."""
        await self._page.evaluate("() => waxPad.unplug()")
