"""Ways to drive other than keys and buttons: joystick and gamepad."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import pytest

from e2e.harness.gamepad import LEFT_OF_CROSS, START, B, InjectedGamepad
from e2e.harness.robot import (
    moves,
    stands_still,
    until_it_moves,
)
from e2e.harness.touch_screen import PHONE, TouchPoints
from e2e.harness.viewer import box_of

if TYPE_CHECKING:
    from e2e.conftest import OpenViewer
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer


pytestmark = pytest.mark.timeout(120)


async def travel_px(viewer: Viewer) -> float:
    """Return the distance that the joystick's knob can travel."""
    await viewer.joystick.scroll_into_view_if_needed()
    return 0.35 * (await box_of(viewer.joystick))["width"]


@pytest.mark.timeout(90)
async def test_a_joystick_out_of_hands_stops(server: Server, open_viewer: OpenViewer) -> None:
    """In the middle a thumb moves nothing; pushed it drives, until the touch is cancelled."""
    viewer = await open_viewer(server, drives=True, **PHONE)
    points = await TouchPoints.of(viewer)
    await points.press(0, viewer.joystick)
    assert not await moves(server, within_s=0.5)
    await points.lift(0)
    push = partial(points.push, 0, viewer.joystick, -await travel_px(viewer), 0)
    await until_it_moves(server, push, partial(points.lift, 0))
    await points.cancel()
    assert await stands_still(server)


async def test_a_gamepad_drives_and_stops(server: Server, open_viewer: OpenViewer) -> None:
    """It drives only once it was chosen; its Stop stops the robot while its cross is still held."""
    viewer = await open_viewer(server, drives=True)
    pad = await InjectedGamepad.plugged_in(viewer.page)
    await viewer.page.get_by_text("Gamepad found").first.wait_for(state="visible")
    await pad.push(1, -1)
    assert not await moves(server, within_s=0.5)
    await pad.push(1, 0)
    await pad.is_seen()
    await pad.tap(START)

    async def let_go() -> None:
        await pad.press(LEFT_OF_CROSS, on=False)
        await pad.is_seen()

    await until_it_moves(server, lambda: pad.press(LEFT_OF_CROSS), let_go)
    await pad.tap(B)
    assert await stands_still(server)
    await viewer.release_stop()
