"""A robot that also moves sideways: by keys, and by two thumbs that hide nothing."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING, Final

import pytest

from e2e.harness import toml
from e2e.harness.boxes import LAYOUTS, SMALL, STOP_IS_WHOLE, THUMB_PX, is_within, overlap
from e2e.harness.robot import pose, stands_still, undisturbed, until_it_moves
from e2e.harness.touch_screen import PHONE, TouchPoints
from e2e.harness.viewer import box_of
from e2e.harness.wait import happens

if TYPE_CHECKING:
    from e2e.conftest import OpenViewer
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer

pytestmark = pytest.mark.timeout(120)

SERVER_SETTINGS = toml.card_with(robot='base = "mecanum"')
BUTTONS: Final = ("Forward", "Back", "Turn left", "Turn right", "Left sideways", "Right sideways")
PUSH_PX: Final = 60


@pytest.mark.parametrize(("keys", "way"), [(["q"], 1), (["Shift", "ArrowRight"], -1)])
async def test_keys_move_the_robot_sideways(
    server: Server, driver: Viewer, keys: list[str], way: int
) -> None:
    """It goes to its left or right, neither ahead nor round, and stops with the key."""

    async def attempt() -> bool:
        start = await pose(server)
        for key in keys:
            await driver.page.keyboard.down(key)

        async def has_gone() -> bool:
            return (await pose(server)).left_m(start) * way > 0.05

        has_moved = await happens(has_gone, within_s=4)
        for key in reversed(keys):
            await driver.page.keyboard.up(key)
        assert await stands_still(server, for_s=0.2)
        at = await pose(server)
        is_straight = abs(at.ahead_m(start)) < 0.02 and abs(at.turned_rad(start)) < 0.05
        return has_moved and is_straight

    assert await undisturbed(server, attempt), f"the robot does not move as {keys} say"


async def test_two_thumbs_move_and_turn_it(server: Server, open_viewer: OpenViewer) -> None:
    """One pushes it to the left while the other turns it; once both are lifted, it stands."""
    viewer = await open_viewer(server, drives=True, **PHONE)
    points = await TouchPoints.of(viewer)
    turn = viewer.page.get_by_role("application", name="Turn left or right", exact=True)
    start = await pose(server)

    async def push() -> None:
        await points.push(0, viewer.joystick, -PUSH_PX, 0)
        await points.push(1, turn, PUSH_PX, 0)

    async def does_both() -> bool:
        async def has_done() -> bool:
            at = await pose(server)
            return at.distance_m(start) > 0.05 and at.turned_rad(start) < -0.1

        return await happens(has_done, within_s=4)

    await until_it_moves(server, push, points.cancel, does_both)
    await points.cancel()
    assert await stands_still(server)


async def test_its_controls_hide_nothing(server: Server, open_viewer: OpenViewer) -> None:
    """Sticks and buttons are as large as a thumb, in the window, and apart; Stop is whole."""
    viewer = await open_viewer(server, drives=True)
    sticks = [viewer.page.get_by_role("application", name=name) for name in ("Joystick", "Turn")]
    buttons = [viewer.button(name) for name in BUTTONS]
    fixed = [viewer.button("Stop"), viewer.page.get_by_role("region", name="Turn", exact=True)]
    for control, drives in (("Joystick", sticks), ("Buttons", buttons)):
        await viewer.resize(*LAYOUTS[0])
        await viewer.drive_by(control)
        await viewer.closes("Settings")
        for width, height in LAYOUTS:
            await viewer.resize(width, height)
            await viewer.lies_still()
            boxes = [await box_of(one) for one in (*drives, *fixed)]
            for one, other in combinations(boxes, 2):
                assert not overlap(one, other), (control, width, height, one, other)
            for box in boxes[:-1]:
                assert min(box["width"], box["height"]) >= THUMB_PX, (control, width, height, box)
                assert is_within(box, width, height), (control, width, height, box)
        for size in SMALL:
            await viewer.resize(*size)
            assert await viewer.page.evaluate(STOP_IS_WHOLE), (control, size)
