"""Other ways to drive than keys and buttons: joystick, gamepad, steps and clicks."""

from __future__ import annotations

import asyncio
import time
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

import pytest
import pytest_asyncio

from e2e.harness import toml
from e2e.harness.gamepad import LEFT_OF_CROSS, START, B, InjectedGamepad
from e2e.harness.robot import holding_moves, moves, nothing_is_held, stands_still, undisturbed
from e2e.harness.touch_screen import TouchPoints
from e2e.harness.viewer import box_of
from e2e.harness.wait import until
from e2e.test_drive import HIDE, LOSSES, PHONE

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from playwright.async_api import Locator

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.board import Board
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer

pytestmark = pytest.mark.timeout(120)

OFFERED = ("Forward", "Left", "Right", "Back", "Stop")
"""To a switch, one after another."""


SERVER_SETTINGS = toml.card_with(turns=toml.BRIEF_GRACE, drive="click_to_move = true")


async def travel_px(viewer: Viewer) -> float:
    """How far the joystick's knob goes."""
    await viewer.joystick.scroll_into_view_if_needed()
    return 0.35 * (await box_of(viewer.joystick))["width"]


@asynccontextmanager
async def settings_of(viewer: Viewer) -> AsyncIterator[Locator]:
    await viewer.open("Settings")
    yield viewer.page.get_by_role("region", name="How you drive", exact=True)
    await viewer.button("Settings").click()


async def choose_way(viewer: Viewer, name: str) -> None:
    async with settings_of(viewer) as ways:
        await ways.get_by_role("radio", name=name, exact=True).check()


async def ready_pad(viewer: Viewer) -> InjectedGamepad:
    """Plug a gamepad in and choose it by its Start."""
    pad = await InjectedGamepad.plugged_in(viewer.page)
    await viewer.page.get_by_text("Gamepad found").first.wait_for(state="visible", timeout=2000)
    await viewer.page.wait_for_timeout(150)
    await pad.tap(START)
    return pad


async def wheels_mmps(board: Board) -> tuple[int, int]:
    """Return what frames ask of the wheels from now on, once that is the same for half a second."""
    begun_s = time.monotonic()

    def steady() -> tuple[int, int] | None:
        if time.monotonic() < begun_s + 1.0:
            return None
        asked = {
            (frame["left"], frame["right"])
            for frame in board.events(time.monotonic() - 0.5)
            if frame["event"] == "frame" and frame["type"] == "drive"
        }
        return asked.pop() if len(asked) == 1 else None

    found = await until(steady, "frames ask steadily for motion", within_s=4)
    assert found is not None
    return found


async def comes_to_rest(board: Board) -> None:
    await until(lambda: not board.moves, "the wheels stand", within_s=1)


# --- in proportion, to the wire ------------------------------------------------------------------


async def test_the_joystick_drives_as_far_as_it_is_pushed(
    serve: Serve, tmp_path: Path, board: Board, open_viewer: OpenViewer
) -> None:
    """A thumb in its middle moves nothing, half way less than at the rim, and lifted it stops."""
    async with serve(tmp_path, toml.card_on(board.path)) as server:
        viewer = await open_viewer(server, drives=True, **PHONE)
        travel = await travel_px(viewer)
        points = await TouchPoints.of(viewer)
        await points.press(0, viewer.joystick)
        await asyncio.sleep(0.5)
        assert not board.moves
        await points.slide(0, 0, -0.6 * travel)
        left, right = await wheels_mmps(board)
        assert left == right > 0
        await points.slide(0, 0, -0.6 * travel)
        full, _ = await wheels_mmps(board)
        assert left < 0.7 * full
        await points.lift(0)
        await comes_to_rest(board)


async def test_a_gamepad_drives_as_far_as_it_is_pushed(
    serve: Serve, tmp_path: Path, board: Board, open_viewer: OpenViewer
) -> None:
    """Not before it was chosen; then its stick drives in proportion, and its loss stops."""
    async with serve(tmp_path, toml.card_on(board.path)) as server:
        viewer = await open_viewer(server, drives=True)
        pad = await InjectedGamepad.plugged_in(viewer.page)
        await pad.push(1, -1)
        await asyncio.sleep(0.5)
        assert not board.moves
        await pad.push(1, 0)
        await pad.tap(START)
        await pad.push(1, -0.6)
        left, right = await wheels_mmps(board)
        assert left == right > 0
        await pad.push(1, -1)
        full, _ = await wheels_mmps(board)
        assert left < 0.7 * full
        await pad.unplug(is_told=False)
        await comes_to_rest(board)


# --- whatever lets go ----------------------------------------------------------------------------


@pytest_asyncio.fixture(loop_scope="session")
async def pushing(server: Server, open_viewer: OpenViewer) -> tuple[Viewer, TouchPoints]:
    """Push the joystick to the left until the robot turns."""
    viewer = await open_viewer(server, drives=True, **PHONE)
    travel = await travel_px(viewer)
    points = await TouchPoints.of(viewer)
    await points.press(0, viewer.joystick)
    await points.slide(0, -travel, 0)
    assert await moves(server)
    return viewer, points


@pytest.mark.timeout(90)
async def test_a_joystick_out_of_hands_stops(
    server: Server, pushing: tuple[Viewer, TouchPoints]
) -> None:
    """Blurred, and by a touch that is cancelled; a finger that moves on changes nothing."""
    viewer, points = pushing
    await viewer.page.evaluate(LOSSES["blur"])
    await points.slide(0, 10, 10)
    assert await stands_still(server)
    await points.lift(0)
    await nothing_is_held(server)
    await points.press(0, viewer.joystick)
    await points.slide(0, -await travel_px(viewer), 0)
    assert await moves(server)
    await points.cancel()
    assert await stands_still(server)


@pytest.mark.full
@pytest.mark.timeout(90)
async def test_a_second_finger_on_the_joystick_does_nothing(
    server: Server, pushing: tuple[Viewer, TouchPoints]
) -> None:
    """It neither moves nor releases it; the first one, lifted, stops."""
    viewer, points = pushing
    await points.press(1, viewer.joystick)
    await points.lift(1)
    assert await moves(server)
    await points.lift(0)
    assert await stands_still(server)


async def test_a_gamepad_that_is_lost_or_left_stops(
    server: Server, open_viewer: OpenViewer
) -> None:
    """Blurred, by its Stop or unplugged: its cross is still held, and yet the robot stands."""
    viewer = await open_viewer(server, drives=True)
    pad = await ready_pad(viewer)
    for loss in ("blur", "stop", "unplugged"):
        await pad.press(LEFT_OF_CROSS)
        assert await moves(server), loss
        if loss == "blur":
            await viewer.page.evaluate(LOSSES["blur"])
        elif loss == "stop":
            await pad.tap(B)
        else:
            await pad.unplug(is_told=True)
        assert await stands_still(server), loss
        if await viewer.button("Hold to release").is_visible():
            await viewer.release_stop()
        if loss != "unplugged":
            await pad.press(LEFT_OF_CROSS, on=False)
            await asyncio.sleep(0.3)


# --- ways ----------------------------------------------------------------------------------------


async def test_keys_and_ways_are_the_operators_choice(
    server: Server, open_viewer: OpenViewer
) -> None:
    """A chosen key drives and one taken away does not; a step ends by itself, and so does a click,
    by its two seconds, another key or a hidden page.
    """
    viewer = await open_viewer(server, drives=True)
    keys = viewer.page.keyboard
    async with settings_of(viewer) as ways:
        await ways.get_by_role("button", name="Add a key for “Left”").click()
        await ways.get_by_text("Press the new key for “Left”").wait_for()
        await keys.press("e")
        await ways.get_by_role("button", name="Take ← away from “Left”").click()
    await keys.down("ArrowLeft")
    assert not await moves(server)
    await keys.up("ArrowLeft")
    assert await holding_moves(server, lambda: keys.down("e"), lambda: keys.up("e"), 0.5)
    await choose_way(viewer, "Steps")

    async def steps() -> bool:
        await keys.down("e")
        moved = await moves(server, during_s=0.4)
        assert await stands_still(server, after_s=0.7)
        await keys.up("e")
        return moved

    assert await undisturbed(server, steps)
    await choose_way(viewer, "Clicks")
    for end in ("two seconds", "a key", "hidden"):
        await viewer.button("Left").click()
        assert await moves(server), end
        if end == "two seconds":
            assert await moves(server)
            await asyncio.sleep(1.0)
        elif end == "a key":
            await keys.press("z")
        else:
            await viewer.page.evaluate(HIDE)
        assert await stands_still(server, after_s=0.5), end


@pytest.mark.timeout(90)
@pytest.mark.parametrize("switches", [1, pytest.param(2, marks=pytest.mark.full)])
async def test_switches_drive_and_stop(
    server: Server, open_viewer: OpenViewer, switches: int
) -> None:
    """One switch chooses what is offered in its turn; with two, the other moves on."""
    viewer = await open_viewer(server, drives=True)
    await choose_way(viewer, "Switch")
    if switches == 2:
        async with settings_of(viewer) as ways:
            await ways.get_by_role("combobox", name="Switches").select_option("2")
    offer = viewer.page.get_by_role("group", name="On offer").locator("[aria-current=true]")

    async def choose(name: str) -> None:
        for _ in range(0 if switches == 1 else len(OFFERED)):
            if await offer.inner_text() == name:
                break
            await viewer.page.keyboard.press("n")
        await offer.get_by_text(name, exact=True).wait_for(timeout=10_000)
        await viewer.page.keyboard.press("Enter")

    async def steps() -> bool:
        await choose("Left")
        moved = await moves(server, during_s=0.4)
        assert await stands_still(server, after_s=0.7)
        return moved

    assert await undisturbed(server, steps)
    await choose("Stop")
    await viewer.button("Hold to release").wait_for()
    await choose("Release the stop")
    await viewer.button("Hold to release").wait_for(state="hidden")
