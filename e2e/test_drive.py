"""The controls, and how the simulated robot responds."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import pytest

from e2e.harness.robot import moves, pose, stands_still, turn_by_key, undisturbed
from e2e.harness.touch_screen import TouchPoints

if TYPE_CHECKING:
    from e2e.conftest import OpenViewer
    from e2e.harness.robot import Pose
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer

pytestmark = pytest.mark.timeout(90)

PHONE: Final = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}


@dataclass(frozen=True, slots=True)
class Drive:
    """From where to where the robot went by one press."""

    start: Pose
    end: Pose

    @property
    def distance_m(self) -> float:
        return self.end.distance_m(self.start)

    @property
    def turned_rad(self) -> float:
        return self.end.turned_rad(self.start)


async def drive_by_keys(server: Server, viewer: Viewer, *keys: str) -> Drive:
    """Hold the keys together, let go, and see the robot stand."""

    async def attempt() -> Drive:
        start = await pose(server)
        for key in keys:
            await viewer.page.keyboard.down(key)
        await asyncio.sleep(0.8)
        for key in keys:
            await viewer.page.keyboard.up(key)
        assert await stands_still(server)
        return Drive(start, await pose(server))

    return await undisturbed(server, attempt)


@pytest.mark.timeout(120)
async def test_keys_move_the_robot(server: Server, driver: Viewer) -> None:
    """Arrow keys and WASD drive where they say, two together a curve, Slow less far than Fast."""
    out = await drive_by_keys(server, driver, "ArrowUp")
    assert out.distance_m > 0.05
    assert abs(out.turned_rad) < 0.05
    home = await drive_by_keys(server, driver, "s")
    assert home.distance_m > 0.05
    assert home.end.distance_m(out.start) < out.distance_m
    assert (await drive_by_keys(server, driver, "a")).turned_rad > 0.1
    curve = await drive_by_keys(server, driver, "ArrowDown", "ArrowLeft")
    assert curve.distance_m > 0.05
    assert abs(curve.turned_rad) > 0.1
    turned: dict[str, float] = {}
    for speed, key in (("Slow", "ArrowLeft"), ("Fast", "ArrowRight")):
        await driver.speed(speed).click()
        turned[speed] = (await drive_by_keys(server, driver, key)).turned_rad
    assert 0.05 < turned["Slow"] < 0.6 * -turned["Fast"], turned


async def test_buttons_work_by_mouse(server: Server, driver: Viewer) -> None:
    """A button held with the mouse drives, let go it stops, also when let go elsewhere."""

    async def attempt() -> Drive:
        start = await pose(server)
        await driver.button("Left").hover()
        await driver.page.mouse.down()
        await asyncio.sleep(0.7)
        await driver.page.mouse.move(2, 2)
        await driver.page.mouse.up()
        assert await stands_still(server)
        return Drive(start, await pose(server))

    assert (await undisturbed(server, attempt)).turned_rad > 0.1


async def test_two_thumbs_drive_a_curve(server: Server, open_viewer: OpenViewer) -> None:
    """On a phone one thumb backs while the other turns; each stops what it alone held."""
    viewer = await open_viewer(server, **PHONE)
    await viewer.drive_by("Buttons")
    await viewer.takes_the_wheel()
    points = await TouchPoints.of(viewer)

    async def attempt() -> tuple[Drive, Drive]:
        start = await pose(server)
        await points.press(0, viewer.button("Back"))
        await points.press(1, viewer.button("Left"))
        await asyncio.sleep(0.8)
        both = Drive(start, await pose(server))
        await points.lift(0)
        await asyncio.sleep(0.5)
        start = await pose(server)
        await asyncio.sleep(0.5)
        one = Drive(start, await pose(server))
        await points.lift(1)
        assert await stands_still(server)
        return both, one

    both, one = await undisturbed(server, attempt)
    assert both.distance_m > 0.03
    assert abs(both.turned_rad) > 0.1
    assert one.distance_m < 0.02
    assert abs(one.turned_rad) > 0.1


async def test_stop_latches_until_it_is_released(
    server: Server, driver: Viewer, open_viewer: OpenViewer
) -> None:
    """It ends the motion of a held key, whoever presses it; only a release and a press go on."""
    await turn_by_key(server, driver)
    await driver.button("Stop").click()
    assert await stands_still(server)
    await driver.page.get_by_text("You stopped the robot").first.wait_for(
        state="visible", timeout=2000
    )
    await driver.page.keyboard.up("ArrowLeft")
    await driver.page.keyboard.down("ArrowLeft")
    assert not await moves(server, during_s=0.8)
    await driver.release_stop()
    assert not await moves(server, during_s=0.8)
    await driver.page.keyboard.up("ArrowLeft")

    watching = await open_viewer(server)
    await watching.call_oneself("Wanda")
    await turn_by_key(server, driver)
    await watching.button("Stop").click()
    assert await stands_still(server)
    for viewer, says in ((driver, "Stopped by Wanda"), (watching, "You stopped the robot")):
        await viewer.page.get_by_text(says).first.wait_for(timeout=2000)
    await driver.page.keyboard.up("ArrowLeft")
    await driver.release_stop()


async def test_keys_that_are_nobodys_commands_move_nothing(
    server: Server, driver: Viewer, open_viewer: OpenViewer
) -> None:
    """Neither an observer's nor those of who waits, nor letters of the operator's own name."""
    watching = await open_viewer(server)
    await watching.page.keyboard.down("ArrowLeft")
    assert not await moves(server, during_s=0.8)
    await watching.page.keyboard.up("ArrowLeft")
    await watching.join()
    await watching.page.keyboard.down("ArrowLeft")
    assert not await moves(server, during_s=0.8)
    await driver.name.click()
    await driver.page.keyboard.down("a")
    assert not await moves(server, during_s=0.6)
    await driver.page.keyboard.up("a")
    assert (await driver.name.input_value()).endswith("a")


# --- however a viewer loses the controls, the robot stands half a second later ---

_SHOWN: Final = """() => {
    Object.defineProperty(document, "visibilityState", { value: "STATE", configurable: true });
    Object.defineProperty(document, "hidden", { value: "STATE" === "hidden", configurable: true });
    document.dispatchEvent(new Event("visibilitychange"));
}"""
HIDE: Final = _SHOWN.replace("STATE", "hidden")
"""What a tab in the background tells its page; headless Chromium keeps every tab in front."""
SHOW: Final = _SHOWN.replace("STATE", "visible")
LOSSES: Final = {"blur": "() => window.dispatchEvent(new Event('blur'))", "hidden": HIDE}
ENDS: Final = {
    "pagehide": "() => window.dispatchEvent(new Event('pagehide'))",
    "a script that hangs": "() => { const end = Date.now() + 2500; while (Date.now() < end); }",
}
"""After these the page has lost its turn."""


async def test_a_page_out_of_hands_stops(server: Server, driver: Viewer) -> None:
    """Blurred or hidden it releases a held key, and a new press drives again."""
    for name, loss in LOSSES.items():
        await turn_by_key(server, driver)
        await driver.page.evaluate(loss)
        assert await stands_still(server), name
        await driver.page.evaluate(SHOW)
        await driver.page.keyboard.up("ArrowLeft")


@pytest.mark.parametrize("leave", ["another address", "a closed tab", *ENDS])
async def test_who_leaves_the_page_stops(server: Server, driver: Viewer, leave: str) -> None:
    """A link, a closed tab, a page put away or one that hangs while a key is held: it stands."""
    await turn_by_key(server, driver)
    if leave == "a closed tab":
        await driver.page.close()
    elif leave == "another address":
        await driver.page.goto("about:blank")
    else:
        leaving = asyncio.create_task(driver.page.evaluate(ENDS[leave]))
        assert await stands_still(server)
        await leaving
    assert await stands_still(server)


async def test_a_cancelled_touch_stops(server: Server, open_viewer: OpenViewer) -> None:
    """A touch that the system takes away releases the button under it."""
    viewer = await open_viewer(server, has_touch=True)
    await viewer.drive_by("Buttons")
    await viewer.takes_the_wheel()
    points = await TouchPoints.of(viewer)
    await points.press(0, viewer.button("Left"))
    assert await moves(server)
    await points.cancel()
    assert await stands_still(server)
