"""Ways to drive as a hand does: press and release, and the browser's events for both."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from e2e.harness.gamepad import START, InjectedGamepad
from e2e.harness.touch_screen import TouchPoints
from e2e.harness.viewer import box_of
from e2e.load.strokes import Stroke

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Sequence

    from e2e.harness.viewer import Viewer
    from wax.config.bases import Base

_AHEAD: Final = "ArrowUp"
_LEFT: Final = "KeyQ"
_PUSH: Final = """
([kind, ahead]) => {
  const now = performance.now();
  waxInputs.push([kind, "", now, now]);
  waxPad.push(1, ahead);
}
"""
"""No browser says when a gamepad moved, so its mover does; ahead is negative on axis 1."""
_FOUND_S: Final = 0.5
_PUSHED: Final = 0.8


class Hand(NamedTuple):
    """Presses and releases, on one page."""

    press: Callable[[], Awaitable[None]]
    release: Callable[[], Awaitable[None]]


@dataclass(frozen=True, slots=True)
class Way:
    """`downs` and `ups` are the browser's events that begin and end a press.

    `reaches` prepares the page that drives, and returns the hand. `code` is the key, where it is
    one, and `base` the robot's.
    """

    key: str
    what: str
    downs: str
    ups: str
    reaches: Callable[[Viewer], Awaitable[Hand]]
    is_touched: bool = False
    code: str = _AHEAD
    base: Base = "differential"

    def strokes(self, noted: Sequence[Sequence[Any]]) -> list[Stroke]:
        """Return when presses began and ended, as noted; the first of several events counts."""
        return [Stroke(kind == self.downs, float(at_ms)) for kind, _, at_ms, _ in self._own(noted)]

    def told_after_ms(self, noted: Sequence[Sequence[Any]]) -> list[float]:
        """Return how long the browser took to notify the page of each press."""
        own = self._own(noted)
        return [float(told - at) for kind, _, at, told in own if kind == self.downs]

    def _own(self, noted: Sequence[Sequence[Any]]) -> list[Sequence[Any]]:
        found: list[Sequence[Any]] = []
        for one in noted:
            kind, code, *_ = one
            if kind not in (self.downs, self.ups) or (code and code != self.code):
                continue
            if (kind == self.downs) is not bool(found and found[-1][0] == self.downs):
                found.append(one)
        return found


async def _key(viewer: Viewer, *, code: str = _AHEAD) -> Hand:
    keyboard = viewer.page.keyboard
    return Hand(partial(keyboard.down, code), partial(keyboard.up, code))


async def _joystick(viewer: Viewer) -> Hand:
    """Put a finger on the middle, which commands nothing, and push it ahead."""
    points = await TouchPoints.of(viewer)
    stick = viewer.joystick
    await stick.scroll_into_view_if_needed()
    ahead_px = -_PUSHED * (await box_of(stick))["height"] / 2

    async def push() -> None:
        await points.press(0, stick)
        await points.slide(0, 0.0, ahead_px)

    return Hand(push, partial(points.lift, 0))


async def _gamepad(viewer: Viewer) -> Hand:
    """Choose the gamepad by its Start; a stick pushed before that moves nothing."""
    pad = await InjectedGamepad.plugged_in(viewer.page)
    await asyncio.sleep(_FOUND_S)
    await pad.tap(START)
    await asyncio.sleep(_FOUND_S)
    push = partial(viewer.page.evaluate, _PUSH)
    return Hand(partial(push, ["paddown", -1]), partial(push, ["padup", 0]))


_TOUCH: Final = ("pointermove", "pointerup")
WAYS: Final = (
    Way("key", "a key", "keydown", "keyup", _key),
    Way(
        "key-sideways",
        "a key for sideways, on four mecanum wheels",
        "keydown",
        "keyup",
        partial(_key, code=_LEFT),
        code=_LEFT,
        base="mecanum",
    ),
    Way("joystick", "the joystick, by touch", *_TOUCH, _joystick, is_touched=True),
    Way("gamepad", "an injected gamepad’s stick", "paddown", "padup", _gamepad),
)
