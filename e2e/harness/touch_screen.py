"""Several touch points at once, through the browser's own input."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from e2e.harness.viewer import box_of

if TYPE_CHECKING:
    from playwright.async_api import CDPSession, Locator

    from e2e.harness.viewer import Viewer

PHONE: Final = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}


class TouchPoints:
    """Each finger rests on one element until it is lifted."""

    def __init__(self, session: CDPSession) -> None:
        self._session = session
        self._points: dict[int, tuple[float, float]] = {}

    @classmethod
    async def of(cls, viewer: Viewer) -> TouchPoints:
        return cls(await viewer.page.context.new_cdp_session(viewer.page))

    async def press(self, finger: int, on: Locator) -> None:
        box = await box_of(on)
        self._points[finger] = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        await self._send("touchStart", self._points)

    async def slide(self, finger: int, right_px: float, down_px: float) -> None:
        x, y = self._points[finger]
        self._points[finger] = (x + right_px, y + down_px)
        await self._send("touchMove", self._points)

    async def push(self, finger: int, on: Locator, right_px: float, down_px: float) -> None:
        """Press in the element's middle, and slide from there."""
        await self.press(finger, on)
        await self.slide(finger, right_px, down_px)

    async def lift(self, finger: int) -> None:
        await self._send("touchEnd", {finger: self._points.pop(finger)})

    async def cancel(self) -> None:
        """Cancel all touches, as the system does for its own gestures."""
        self._points.clear()
        await self._send("touchCancel", {})

    async def _send(self, kind: str, points: dict[int, tuple[float, float]]) -> None:
        touches = [{"x": x, "y": y, "id": finger} for finger, (x, y) in points.items()]
        await self._session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": touches})
