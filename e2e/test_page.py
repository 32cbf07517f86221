"""The page can be used by thumb, and nothing is in the way."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Final

import pytest
from playwright.async_api import expect

from e2e.harness.boxes import (
    LAYOUTS,
    SMALL,
    STOP_IS_WHOLE,
    THUMB_PX,
    UPRIGHT,
    is_within,
    overlap,
)
from e2e.harness.touch_screen import PHONE
from e2e.harness.viewer import box_of
from e2e.harness.wait import eventually
from wax.client import Operator

if TYPE_CHECKING:
    from e2e.conftest import OpenViewer
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer

DRIVE_BUTTONS: Final = ("Forward", "Back", "Left", "Right")
LETTERS_PX: Final = 24
"""A browser's setting; 16 is usual."""
PANELS: Final = ("People", "Settings", "Details", "Safety")


async def test_a_phone_has_everything_under_the_thumbs(
    server: Server, open_viewer: OpenViewer
) -> None:
    """On a phone nothing scrolls sideways, and the controls for driving are large and in view."""
    viewer = await open_viewer(server, drives=True, **PHONE)
    for control in ("Joystick", "Buttons"):
        await viewer.drive_by(control)
        await viewer.closes("Settings")
        await viewer.lies_still()
        assert await viewer.page.evaluate("() => document.documentElement.scrollWidth") <= 390
        assert await viewer.page.evaluate("() => window.scrollY") == 0
        stick = viewer.joystick
        is_stick = control == "Joystick"
        drives = [stick] if is_stick else [viewer.button(name) for name in DRIVE_BUTTONS]
        for name in (*drives, viewer.button("Stop")):
            box = await box_of(name)
            assert min(box["width"], box["height"]) >= THUMB_PX, (name, box)
            assert is_within(box, 390, 844), (name, box)


async def test_nothing_that_is_opened_hides_what_a_driver_must_see(driver: Viewer) -> None:
    """Panels cover neither turn, buttons nor Stop, and fit in; the picture fills its box."""
    page = driver.page
    for width, height in LAYOUTS:
        await driver.resize(width, height)
        box = await box_of(page.get_by_role("region", name="Picture", exact=True))
        assert box["width"] / box["height"] == pytest.approx(640 / 480, rel=0.02), (width, height)
        assert is_within(box, width, height), (width, height)
    for width, height in LAYOUTS:
        await driver.resize(width, height)
        for panel in PANELS:
            await driver.open(panel)
            await driver.lies_still()
            opened = await box_of(page.get_by_role("region", name=panel, exact=True))
            assert not overlap(opened, await box_of(page.get_by_role("region", name="Turn")))
            for name in (*DRIVE_BUTTONS, "Stop"):
                where = (width, height, panel, name)
                assert not overlap(opened, await box_of(driver.button(name))), where
            assert is_within(await box_of(driver.button("Stop")), width, height), (width, panel)


async def test_on_a_wide_screen_what_is_opened_stands_under_the_picture(
    server: Server, open_viewer: OpenViewer
) -> None:
    """It is as wide as the picture was; Stop and the card stay where they are."""
    viewer = await open_viewer(server, viewport={"width": 1280, "height": 800})
    picture = viewer.page.get_by_role("region", name="Picture", exact=True)
    fixed = [viewer.button("Stop"), viewer.page.get_by_role("region", name="Turn")]
    before, alone = [await box_of(one) for one in fixed], await box_of(picture)
    await viewer.open("Details")
    opened = await box_of(viewer.page.get_by_role("region", name="Details", exact=True))
    beside = await box_of(picture)
    for box, one in zip(before, fixed, strict=True):
        assert await box_of(one) == pytest.approx(box, abs=0.5)
    assert opened["width"] == pytest.approx(alone["width"], abs=1)
    assert opened["y"] > beside["y"] + beside["height"]
    assert beside["width"] / beside["height"] == pytest.approx(640 / 480, rel=0.02)
    assert is_within(opened, 1280, 800)


async def test_who_waits_can_read_why(server: Server, open_viewer: OpenViewer) -> None:
    """The hint over the picture is light there."""
    viewer = await open_viewer(server)
    async with Operator(server.url, name="Bob") as operator:
        await operator.join()
        await viewer.resize(844, 390)
        await viewer.join()
        hint = viewer.page.get_by_text("You drive when it is your turn.", exact=True)
        await hint.wait_for()
        colour = "one => getComputedStyle(one).color"
        assert await hint.evaluate(colour) == await viewer.button("Safety").evaluate(colour)
        await viewer.leave()


async def test_stop_is_whole_in_a_small_window(server: Server, open_viewer: OpenViewer) -> None:
    """Whoever drives, or has stopped the robot, can press all of Stop without scrolling."""
    viewer = await open_viewer(server, drives=True)
    for is_stopped in (False, True):
        if is_stopped:
            await viewer.button("Stop").click()
            await expect(viewer.page.get_by_text("You stopped the robot")).to_be_visible()
        for size in SMALL:
            await viewer.resize(*size)
            assert await viewer.page.evaluate(STOP_IS_WHOLE), (size, is_stopped)
    await viewer.release_stop()
    await viewer.leave()


async def test_a_small_window_shows_the_whole_welcome(
    server: Server, open_viewer: OpenViewer
) -> None:
    """Its heading is not covered by the bar over the picture."""
    viewer = await open_viewer(server, viewport={"width": 640, "height": 360})
    heading = viewer.page.get_by_role("heading", name="Welcome")
    seen = """one => {
        document.querySelector(".hud").style.pointerEvents = "auto"; // or it cannot be found
        const { left, top, height } = one.getBoundingClientRect();
        return one.contains(document.elementFromPoint(left + 8, top + height / 2));
    }"""
    assert await heading.evaluate(seen)


async def test_larger_letters_leave_everything_in_its_place(
    server: Server, open_viewer: OpenViewer
) -> None:
    """Letters have the browser's size; Stop is fully visible, and nothing scrolls sideways."""
    viewer = await open_viewer(server, drives=True)
    page = viewer.page
    devtools = await page.context.new_cdp_session(page)
    await devtools.send("Page.setFontSizes", {"fontSizes": {"standard": LETTERS_PX}})
    for width, height in (*LAYOUTS, *UPRIGHT):
        where = (width, height)
        await viewer.resize(width, height)
        size = await page.evaluate("getComputedStyle(document.body).fontSize")
        assert size == f"{LETTERS_PX}px"
        assert await page.evaluate(STOP_IS_WHOLE), where
        assert await page.evaluate("document.documentElement.scrollWidth") <= width, where
    await viewer.leave()


async def test_a_small_window_gets_a_small_picture(server: Server, open_viewer: OpenViewer) -> None:
    """What a window cannot show is not sent, and comes again once the window is large."""
    viewer = await open_viewer(server)

    async def is_sent(width: int) -> bool:
        sent = await viewer.page.evaluate("document.querySelector('video').videoWidth")
        return bool(sent == width)

    for (across, down), width in (((1280, 800), 640), ((560, 300), 320), ((1280, 800), 640)):
        await viewer.resize(across, down)
        await eventually(partial(is_sent, width), f"the picture is {width} pixels wide")
