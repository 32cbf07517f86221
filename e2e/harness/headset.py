"""A headset with two Touch controllers, emulated in a page by Meta's iwer."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from e2e.harness.wait import happens
from e2e.measure.errors import NotRunError
from e2e.measure.suite import ROOT

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from e2e.harness.scripts import Window
    from e2e.harness.viewer import Viewer

_SOURCE: Final = ROOT / "web/node_modules/iwer/build/iwer.min.js"
_PUT_ON: Final = """
window.waxHeadset = new IWER.XRDevice(IWER.metaQuest3, { stereoEnabled: true });
waxHeadset.installRuntime({ forceInstall: true });
"""
_SEEN: Final = "() => new Promise((seen) => setTimeout(seen, 100))"
"""A frame, and a reading of the controllers every 50 ms; by the page's timers, as it reads them."""
SMALL: Final[dict[str, Any]] = {"viewport": {"width": 800, "height": 600}}
"""A window of which a processor without graphics draws each frame in time, as a headset does."""
STOPS: Final = {"left": "y-button", "right": "b-button"}


def worn() -> str:
    """Return the script that gives a page its headset, before any other script."""
    if not _SOURCE.exists():
        raise NotRunError("iwer is not installed: type make test, or npm ci in web/")
    return _SOURCE.read_text(encoding="utf-8") + _PUT_ON


class EmulatedHeadset:
    """What somebody does who wears it; a hand is ``"left"`` or ``"right"``."""

    def __init__(self, window: Window) -> None:
        self._window = window

    @classmethod
    async def entered(cls, viewer: Viewer) -> EmulatedHeadset:
        """Enter by the button in the page's settings."""
        await viewer.open("Settings")
        await viewer.button("Headset").click()
        await viewer.button("Leave the headset").wait_for()
        made = cls(viewer.page)
        await made.is_seen()
        return made

    async def squeeze(self, hand: str = "left", *, on: bool = True) -> None:
        await self._press(hand, "squeeze", on=on)

    async def push(self, hand: str, across: float = 0, along: float = 0) -> None:
        """Push a stick; right and back are positive."""
        await self._window.evaluate(
            f"waxHeadset.controllers.{hand}.updateAxes('thumbstick', {across}, {along})"
        )

    async def tap(self, hand: str, button: str) -> None:
        """Press a button, and release it once the page has seen that."""
        await self._press(hand, button, on=True)
        await self.is_seen()
        await self._press(hand, button, on=False)
        await self.is_seen()

    async def hold_trigger(self, until: Callable[[], Awaitable[bool]]) -> bool:
        """Hold the right trigger until this is true, or for 3 s; return whether it became true."""
        await self._press("right", "trigger", on=True)
        is_true = await happens(until, within_s=3.0)
        await self._press("right", "trigger", on=False)
        await self.is_seen()
        return is_true

    async def turn_left(self) -> None:
        """Squeeze, then push the right stick once the page has seen both sticks at rest."""
        await self.squeeze()
        await self.is_seen()
        await self.push("right", across=-1)

    async def let_go(self) -> None:
        """Let go of both sticks and of the grip."""
        await self.push("left")
        await self.push("right")
        await self.squeeze(on=False)
        await self.is_seen()

    async def become(self, visibility: str) -> None:
        """Be ``"hidden"``, as when taken off, ``"visible-blurred"`` or ``"visible"`` again."""
        await self._window.evaluate(f"waxHeadset.updateVisibilityState('{visibility}')")

    async def is_lost(self) -> None:
        """End the session, as the headset's own menu does."""
        await self._window.evaluate("waxHeadset.activeSession.end()")

    async def is_seen(self) -> None:
        """Wait until the page has read it again."""
        await self._window.evaluate(f"({_SEEN})()")

    async def _press(self, hand: str, button: str, *, on: bool) -> None:
        await self._window.evaluate(
            f"waxHeadset.controllers.{hand}.updateButtonValue('{button}', {int(on)})"
        )
