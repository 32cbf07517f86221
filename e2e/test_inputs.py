"""Other ways to drive than keys and buttons: joystick, gamepad, steps and clicks."""

from __future__ import annotations

import asyncio
import time
from contextlib import asynccontextmanager
from functools import partial
from typing import TYPE_CHECKING

import pytest
from playwright.async_api import expect

from e2e.harness import toml
from e2e.harness.gamepad import LEFT_OF_CROSS, START, B, InjectedGamepad
from e2e.harness.robot import (
    drives_on,
    holding_moves,
    moves,
    stands_still,
    undisturbed,
    until_it_moves,
)
from e2e.harness.touch_screen import TouchPoints
from e2e.harness.viewer import box_of
from e2e.harness.wait import happens, until
from e2e.test_drive import PHONE

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from playwright.async_api import Locator

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.board import Board
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer


pytestmark = pytest.mark.timeout(120)

BY_ITSELF_S = 3.0
"""A page's own timer ends a step and a click; how soon is asked of a clock that is turned."""


SERVER_SETTINGS = toml.card_with(drive="click_to_move = true")


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


def asked_mmps(board: Board, since_s: float) -> set[tuple[int, int]]:
    """Return what frames have asked of the wheels, of those that ask for motion."""
    return {
        (frame["left"], frame["right"])
        for frame in board.events(since_s)
        if frame["event"] == "frame" and frame["type"] == "drive"
    }


async def goes_further(board: Board, points: TouchPoints, stick: Locator, half_px: float) -> bool:
    """Return whether half a push drives straight ahead, and a whole one clearly faster."""
    asked: set[tuple[int, int]] = set()

    async def is_steady() -> bool:
        nonlocal asked
        from_s = time.monotonic() - 0.4
        asked = asked_mmps(board, from_s)
        return len(asked) == 1 and begun_s < from_s

    async def is_faster() -> bool:
        return any(min(wheels) > left_mmps / 0.7 for wheels in asked_mmps(board, begun_s))

    begun_s = time.monotonic()
    await points.push(0, stick, 0, -half_px)
    goes_on = await happens(is_steady, within_s=4)
    if goes_on:
        [(left_mmps, right_mmps)] = asked
        assert left_mmps == right_mmps > 0
        begun_s = time.monotonic()
        await points.slide(0, 0, -half_px)
        goes_on = await happens(is_faster, within_s=4)
    await points.lift(0)
    await until(lambda: not board.moves, "the wheels stand", within_s=1)
    return goes_on


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
        await points.lift(0)
        attempt = partial(goes_further, board, points, viewer.joystick, 0.6 * travel)
        assert await undisturbed(server, attempt)


# --- whatever lets go ----------------------------------------------------------------------------


@pytest.mark.timeout(90)
async def test_a_joystick_out_of_hands_stops(server: Server, open_viewer: OpenViewer) -> None:
    """By a touch that is cancelled."""
    viewer = await open_viewer(server, drives=True, **PHONE)
    points = await TouchPoints.of(viewer)
    push = partial(points.push, 0, viewer.joystick, -await travel_px(viewer), 0)
    await until_it_moves(server, push, partial(points.lift, 0))
    await points.cancel()
    assert await stands_still(server)


async def test_a_gamepad_drives_and_stops(server: Server, open_viewer: OpenViewer) -> None:
    """Not before it was chosen it drives; by its Stop the robot stands, its cross still held."""
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


# --- ways ----------------------------------------------------------------------------------------


@pytest.mark.full
async def test_keys_and_ways_are_the_operators_choice(
    server: Server, open_viewer: OpenViewer
) -> None:
    """A chosen key drives and one taken away does not; a step and a click end by themselves."""
    viewer = await open_viewer(server, drives=True)
    keys = viewer.page.keyboard
    async with settings_of(viewer) as ways:
        await ways.get_by_role("button", name="Add a key for “Left”").click()
        await ways.get_by_text("Press the new key for “Left”").wait_for()
        await keys.press("e")
        await ways.get_by_role("button", name="Take ← away from “Left”").click()
    await keys.down("ArrowLeft")
    assert not await moves(server, within_s=0.5)
    await keys.up("ArrowLeft")
    assert await holding_moves(server, lambda: keys.down("e"), lambda: keys.up("e"))
    await choose_way(viewer, "Steps")

    async def steps() -> bool:
        await keys.down("e")
        moved = await moves(server)
        assert await stands_still(server, after_s=BY_ITSELF_S)
        await keys.up("e")
        return moved

    assert await undisturbed(server, steps)
    await choose_way(viewer, "Clicks")

    async def clicks() -> bool:
        await viewer.button("Left").click()
        moved = await moves(server)
        await asyncio.sleep(0.4)  # no step lasts as long
        moved = moved and await drives_on(server)
        assert await stands_still(server, after_s=BY_ITSELF_S)
        return moved

    assert await undisturbed(server, clicks)


@pytest.mark.full
@pytest.mark.timeout(90)
@pytest.mark.parametrize("switches", [1, 2])
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
        while switches == 2 and (offered := await offer.inner_text()) != name:
            await viewer.page.keyboard.press("n")
            await expect(offer).not_to_have_text(offered)
        await expect(offer).to_have_text(name, timeout=10_000)
        await viewer.page.keyboard.press("Enter")

    async def steps() -> bool:
        await choose("Left")
        moved = await moves(server)
        assert await stands_still(server, after_s=BY_ITSELF_S)
        return moved

    assert await undisturbed(server, steps)
    await choose("Stop")
    await viewer.button("Hold to release").wait_for()
    await choose("Release the stop")
    await viewer.button("Hold to release").wait_for(state="hidden")
