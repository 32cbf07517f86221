"""A screen in a hall: `?view=big-screen`."""

from __future__ import annotations

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
"""Visitors use this name, and so does the test; its requests go to the server's own address."""


@pytest.mark.full
@pytest.mark.timeout(90)
async def test_a_screen_is_all_picture_with_a_code_that_leads_here(
    server: Server, open_viewer: OpenViewer
) -> None:
    """Pointer and Stop appear once somebody moves; a camera can read the page's own address."""
    screen = await open_viewer(server, **HALL)
    await screen.page.goto(f"{server.url}/?view=big-screen")
    await screen.sees_picture()
    video = await screen.page.locator("video").bounding_box()
    assert video == {"x": 0, "y": 0, **HALL["viewport"]}
    main = screen.page.get_by_role("main")
    await expect(main).to_have_css("cursor", "none")
    await screen.page.mouse.move(300, 300)
    await screen.page.mouse.move(320, 300)
    await expect(main).not_to_have_css("cursor", "none")
    await screen.button("Stop").click(trial=True)  # it would be pressed

    await screen.is_reached_as(NAME)
    await screen.page.goto(f"{NAME}/?view=big-screen")
    code = screen.page.get_by_role("img", name=f"QR code with the address {NAME}/", exact=True)
    picture = np.frombuffer(await code.screenshot(), np.uint8)
    seen = cv2.imdecode(picture, cv2.IMREAD_COLOR)
    assert seen is not None, "the code is no picture"
    read, _, _ = cv2.QRCodeDetector().detectAndDecode(seen)
    assert read == f"{NAME}/"
    # When the page closes, requests in flight have no one to wait for them.
    await screen.page.unroute_all(behavior="ignoreErrors")
