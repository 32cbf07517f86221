"""A gamepad in a page, which finds it like a real one: by `navigator.getGamepads` and events."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from e2e.harness.scripts import Window

B: Final = 1
START: Final = 9
LEFT_OF_CROSS: Final = 14
"""Buttons of the standard layout (W3C Gamepad)."""

_SCRIPT: Final = Path(__file__).with_name("gamepad.js").read_text(encoding="utf-8")
_SEEN: Final = "() => new Promise((seen) => setTimeout(seen, 100))"
"""A page reads gamepads every 50 ms, by its own timers, which a busy machine delays alike."""


class InjectedGamepad:
    """One gamepad, by default a standard one, in the place of all that the browser knows."""

    def __init__(self, window: Window) -> None:
        self._window = window

    @classmethod
    async def plugged_in(cls, window: Window, **more: Any) -> InjectedGamepad:
        """Plug one in; `more` are its id, mapping and number of buttons, if it is another."""
        await window.evaluate(f"({_SCRIPT})()")
        await window.evaluate(f"waxPad.plug({json.dumps(more)})")
        return cls(window)

    async def push(self, axis: int, value: float) -> None:
        """Push a stick: axis 0 is left to right, axis 1 ahead (-1) to back."""
        await self._window.evaluate(f"waxPad.push({axis}, {value})")

    async def is_seen(self) -> None:
        """Wait until the page has read it again."""
        await self._window.evaluate(f"({_SEEN})()")

    async def press(self, button: int, *, on: bool = True) -> None:
        await self._window.evaluate(f"waxPad.press({button}, {str(on).lower()})")

    async def tap(self, button: int) -> None:
        """Press a button, and release it once the page has seen that."""
        await self.press(button)
        await self.is_seen()
        await self.press(button, on=False)
        await self.is_seen()
