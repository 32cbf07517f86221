"""The controls, and how the simulated robot responds."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Final

import pytest

from e2e.harness.robot import (
    STANDS_WITHIN_S,
    moves,
    pose,
    stands_still,
    turn_by_key,
    undisturbed,
)
from e2e.harness.touch_screen import PHONE, TouchPoints
from e2e.harness.wait import happens

if TYPE_CHECKING:
    from collections.abc import Callable

    from e2e.conftest import OpenViewer
    from e2e.harness.robot import Pose
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer

    Went = Callable[[Pose, Pose], bool]
    """A function of where the robot is, and of where it was before the press."""

pytestmark = pytest.mark.timeout(90)

NO_HTTP: Final = "void (window.fetch = () => new Promise(() => {}))"
NO_CHANNEL: Final = "void (frames[0].RTCDataChannel.prototype.send = () => {})"
"""In the empty frame in which the page makes its connections."""


async def goes(server: Server, start: Pose, so: Went) -> bool:
    """Return whether the robot has moved so from there, as soon as it has."""

    async def has_gone() -> bool:
        return so(await pose(server), start)

    return await happens(has_gone, within_s=4)


async def drive_by_keys(server: Server, viewer: Viewer, *keys: str, so: Went) -> None:
    """Hold the keys together until the robot has moved so, release, and check that it stops so."""

    async def attempt() -> bool:
        start = await pose(server)
        for key in keys:
            await viewer.page.keyboard.down(key)
        has_gone = await goes(server, start, so)
        for key in keys:
            await viewer.page.keyboard.up(key)
        assert await stands_still(server, for_s=0.2)
        return has_gone and so(await pose(server), start)

    assert await undisturbed(server, attempt), f"the robot does not drive as {keys} say"


def turned_left(at: Pose, since: Pose) -> bool:
    return at.turned_rad(since) > 0.1


async def speed_mps(server: Server) -> float:
    return abs(float((await server.status())["robot"]["speed_mps"]))


@pytest.mark.timeout(120)
async def test_keys_move_the_robot(server: Server, driver: Viewer) -> None:
    """Arrow keys and WASD drive in their directions, two together in a curve."""
    await drive_by_keys(
        *(server, driver, "ArrowUp"),
        so=lambda at, since: at.ahead_m(since) > 0.05 and abs(at.turned_rad(since)) < 0.05,
    )
    await drive_by_keys(server, driver, "s", so=lambda at, since: at.ahead_m(since) < -0.05)
    await drive_by_keys(server, driver, "a", so=turned_left)
    await drive_by_keys(
        *(server, driver, "ArrowRight"), so=lambda at, since: at.turned_rad(since) < -0.1
    )
    await drive_by_keys(
        *(server, driver, "ArrowDown", "ArrowLeft"),
        so=lambda at, since: at.distance_m(since) > 0.05 and abs(at.turned_rad(since)) > 0.1,
    )


async def test_buttons_work_by_mouse(server: Server, driver: Viewer) -> None:
    """A button held with the mouse drives and stops when released, even if released elsewhere."""

    async def turns() -> bool:
        start = await pose(server)
        await driver.button("Left").hover()
        await driver.page.mouse.down()
        has_turned = await goes(server, start, turned_left)
        await driver.page.mouse.move(2, 2)
        await driver.page.mouse.up()
        assert await stands_still(server)
        return has_turned

    assert await undisturbed(server, turns)


async def test_two_thumbs_drive_a_curve(server: Server, open_viewer: OpenViewer) -> None:
    """On a phone one thumb reverses while the other turns; each releases only its own direction."""
    viewer = await open_viewer(server, **PHONE)
    await viewer.drive_by("Buttons")
    await viewer.takes_the_wheel()
    points = await TouchPoints.of(viewer)

    async def backs_no_more() -> bool:
        return await speed_mps(server) < 0.001

    async def both_and_one() -> bool:
        start = await pose(server)
        await points.press(0, viewer.button("Back"))
        await points.press(1, viewer.button("Left"))
        both = await goes(
            *(server, start),
            lambda at, since: at.distance_m(since) > 0.03 and abs(at.turned_rad(since)) > 0.1,
        )
        await points.lift(0)
        one = await happens(backs_no_more, within_s=STANDS_WITHIN_S)
        start = await pose(server)
        one = one and await goes(server, start, lambda at, since: abs(at.turned_rad(since)) > 0.1)
        end = await pose(server)
        await points.lift(1)
        assert await stands_still(server)
        return both and one and end.distance_m(start) < 0.02

    assert await undisturbed(server, both_and_one)


async def test_stop_latches_until_it_is_released(
    server: Server, driver: Viewer, open_viewer: OpenViewer
) -> None:
    """It ends the motion of a held key, whoever presses; only a release and a new press drive on.

    Each of its two paths is enough: HTTP is blocked for the operator, the channel for the observer.
    """
    await turn_by_key(server, driver)
    await driver.page.evaluate(NO_HTTP)
    await driver.button("Stop").click()
    assert await stands_still(server)
    await driver.page.get_by_text("You stopped the robot").first.wait_for()
    await driver.page.keyboard.up("ArrowLeft")
    await driver.page.keyboard.down("ArrowLeft")
    assert not await moves(server, within_s=0.5)
    await driver.release_stop()
    assert not await moves(server, within_s=0.5)
    await driver.page.keyboard.up("ArrowLeft")

    watching = await open_viewer(server)
    await watching.call_oneself("Wanda")
    await turn_by_key(server, driver)
    await watching.page.evaluate(NO_CHANNEL)
    await watching.button("Stop").click()
    assert await stands_still(server)
    for viewer, says in ((driver, "Stopped by Wanda"), (watching, "You stopped the robot")):
        await viewer.page.get_by_text(says).first.wait_for()
    await driver.page.keyboard.up("ArrowLeft")
    await driver.release_stop()


# --- however a viewer loses the controls, the robot stops at once ---

HANG: Final = "() => { const end = Date.now() + 2500; while (Date.now() < end); }"


@pytest.mark.parametrize("leave", ["another address", "a script that hangs", "a closed tab"])
async def test_who_leaves_the_page_stops(server: Server, driver: Viewer, leave: str) -> None:
    """If a link is followed, a tab closed or the page hangs, a held key drives no longer."""
    await turn_by_key(server, driver)
    if leave == "a closed tab":
        await driver.page.close()
    elif leave == "another address":
        await driver.page.goto("about:blank")
    else:
        leaving = asyncio.create_task(driver.page.evaluate(HANG))
        assert await stands_still(server)
        await leaving
    assert await stands_still(server)
    if leave == "another address":
        await driver.page.go_back()
        await driver.drives()  # but the robot still stands
        assert not await moves(server, within_s=0.5)
