"""Chromium shaped like a Quest's browser, and with an emulated headset."""

from __future__ import annotations

from typing import TYPE_CHECKING

from e2e.harness.gamepad import InjectedGamepad
from e2e.harness.headset import SMALL, STOPS, EmulatedHeadset, worn
from e2e.harness.quest import HEADSET, SHAPE, SQUEEZE, STICK_ACROSS, STICK_ALONG, TOUCH
from e2e.harness.robot import moves, stands_still, turn_by_key, until_it_moves
from e2e.harness.wait import eventually

if TYPE_CHECKING:
    from e2e.conftest import OpenViewer
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer


async def test_in_a_headset_one_watches_and_drives_by_its_controller(
    server: Server, open_viewer: OpenViewer
) -> None:
    """It takes the server's offer, and drives by the stick that was pushed to choose it."""
    viewer = await open_viewer(server, first=SHAPE, drives=True, **HEADSET)
    pad = await takes_the_controller(viewer)
    for use, axis in (("Go ahead", STICK_ALONG), ("Turn left", STICK_ACROSS)):
        await viewer.button(f"Choose a part for “{use}”").tap()
        await viewer.page.get_by_text("Push the stick or lever").wait_for()
        await pad.push(axis, -1)
        await pad.is_seen()
        await pad.push(axis, 0)
        await viewer.button(f"Take axis {axis + 1} away from “{use}”").wait_for()

    async def let_go() -> None:
        await pad.push(STICK_ACROSS, 0)
        await pad.is_seen()

    await viewer.page.get_by_text("The gamepad is ready").wait_for()
    # A stick begins near its middle; one that jumps away is not trusted (`padRest.ts`).
    await pad.push(STICK_ACROSS, -0.1)
    await pad.is_seen()
    await until_it_moves(server, lambda: pad.push(STICK_ACROSS, -1), let_go)
    await pad.tap(SQUEEZE)
    assert await stands_still(server)
    await let_go()
    await viewer.release_stop()

    await viewer.page.reload()
    await viewer.sees_picture()
    await takes_the_controller(viewer)
    await viewer.button("Take axis 4 away from “Go ahead”").wait_for()


async def test_in_a_session_one_drives_and_stops(server: Server, open_viewer: OpenViewer) -> None:
    """Nothing moves without a squeeze; a button of either hand is Stop, a held trigger ends it."""
    viewer = await open_viewer(server, first=worn(), drives=True, **SMALL)
    headset = await EmulatedHeadset.entered(viewer)
    await headset.push("right", across=-1)
    assert not await moves(server, within_s=0.5)
    await headset.squeeze()  # the stick was pushed before
    assert not await moves(server, within_s=0.5)
    await headset.let_go()
    release = viewer.button("Hold to release")
    for hand, button in STOPS.items():
        await until_it_moves(server, headset.turn_left, headset.let_go)
        await headset.tap(hand, button)
        assert await stands_still(server)
        await headset.let_go()
        await release.wait_for()  # a trigger that was pressed before counts for no Stop
        await eventually(
            lambda: headset.hold_trigger(until=release.is_hidden), "the stop is released"
        )
        assert (await server.status())["stop"] is None


async def test_taken_off_or_lost_it_stops_the_robot(
    server: Server, open_viewer: OpenViewer
) -> None:
    """Put on again it needs a new squeeze; without its session the page is as before."""
    viewer = await open_viewer(server, first=worn(), drives=True, **SMALL)
    headset = await EmulatedHeadset.entered(viewer)
    await until_it_moves(server, headset.turn_left, headset.let_go)
    await headset.become("hidden")
    assert await stands_still(server)
    await headset.become("visible")
    assert await stands_still(server)
    await headset.let_go()
    await until_it_moves(server, headset.turn_left, headset.let_go)
    await headset.is_lost()
    assert await stands_still(server)
    await viewer.button("Headset").wait_for()
    assert await viewer.cards(3)
    await turn_by_key(server, viewer)


async def takes_the_controller(viewer: Viewer) -> InjectedGamepad:
    """Choose the controller, which has no Start, by its name."""
    pad = await InjectedGamepad.plugged_in(viewer.page, **TOUCH)
    await viewer.open("Settings")
    choice = viewer.page.get_by_role("combobox", name="Gamepad", exact=True)
    await choice.select_option(label=TOUCH["id"])
    return pad
