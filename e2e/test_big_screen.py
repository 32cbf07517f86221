"""A screen in a hall: `?view=big-screen`."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import cv2
import numpy as np
import pytest
from playwright.async_api import expect

if TYPE_CHECKING:
    from e2e.conftest import OpenViewer
    from e2e.harness.server import Server

HALL = {"viewport": {"width": 1280, "height": 720}}
NAME = "http://robot.example"
"""By this the page is opened here, as by visitors; its requests go to the server's own address."""


@pytest.mark.full
@pytest.mark.timeout(90)
async def test_a_screen_shows_who_drives_and_takes_no_place(
    server: Server, open_viewer: OpenViewer
) -> None:
    """It shows the picture, who drives and for how long; a place kept for its tab is given back.

    Stop and the pointer are hidden until somebody moves (and again 3 s later, as a page's test has
    it); pressed, it stops the robot. A camera reads the page's own address from its code.
    """
    screen = await open_viewer(server, drives=True, **HALL)
    await screen.page.goto(f"{server.url}/?view=big-screen")
    await screen.sees_picture()
    await expect(screen.page.get_by_text("Nobody is driving: the robot is free")).to_be_visible()
    driver = await open_viewer(server)
    await driver.call_oneself("Grace")
    await driver.takes_the_wheel()
    await expect(screen.page.get_by_text("Grace is driving")).to_be_visible()
    await expect(screen.timer).to_have_text(re.compile(r"^[01]:"))
    video = await screen.page.locator("video").bounding_box()
    assert video == {"x": 0, "y": 0, **HALL["viewport"]}
    main = screen.page.get_by_role("main")
    await expect(main).to_have_css("cursor", "none")
    await screen.page.mouse.move(300, 300)
    await screen.page.mouse.move(320, 300)
    await expect(main).not_to_have_css("cursor", "none")
    await screen.button("Stop").click()
    await expect(screen.page.get_by_text("Stopped by")).to_be_visible()
    await driver.release_stop()

    await screen.is_reached_as(NAME)
    await screen.page.goto(f"{NAME}/?view=big-screen")
    code = screen.page.get_by_role("img", name=f"QR code with the address {NAME}/", exact=True)
    picture = np.frombuffer(await code.screenshot(), np.uint8)
    seen = cv2.imdecode(picture, cv2.IMREAD_COLOR)
    assert seen is not None, "the code is no picture"
    read, _, _ = cv2.QRCodeDetector().detectAndDecode(seen)
    assert read == f"{NAME}/"
    # What is under way when the page closes is nobody's any more.
    await screen.page.unroute_all(behavior="ignoreErrors")
