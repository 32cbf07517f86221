"""The page can be used in a language that is longer and mirrored."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import pytest
from playwright.async_api import expect

from e2e.harness.viewer import box_of

if TYPE_CHECKING:
    from e2e.conftest import OpenViewer
    from e2e.harness.server import Server

SIZES = ((390, 844), (844, 390), (1280, 800))
"""A phone held upright and across, and a large window."""

STOP = re.compile(r"^\W*Šţö+p")
SETTINGS = re.compile(r"^\W*Šé+ţ")
JOIN = re.compile(r"^\W*Ĵö+î+ñ")
LEFT = re.compile(r"^\W*Ļé+f")
RIGHT = re.compile(r"^\W*Ŕî+ĝ")
"""The numbers as the trial language writes them."""


@pytest.mark.full
async def test_a_long_language_from_right_to_left_keeps_the_page_usable(
    server: Server, open_viewer: OpenViewer
) -> None:
    """In a mirrored language, two fifths longer, nothing is cut off, and left is still left."""
    viewer = await open_viewer(server)
    page = viewer.page
    await page.goto(f"{server.url}/?lang=pseudo")
    await viewer.sees_picture()
    await expect(page.locator("html")).to_have_attribute("dir", "rtl")
    await viewer.button(JOIN).click()
    for width, height in SIZES:
        await expect(viewer.button(LEFT)).to_be_visible()
        await viewer.resize(width, height)
        left, right = await box_of(viewer.button(LEFT)), await box_of(viewer.button(RIGHT))
        assert left["x"] + left["width"] <= right["x"]
        stop = await box_of(viewer.button(STOP))
        assert stop["y"] >= 0
        assert stop["y"] + stop["height"] <= height
        for _panel in ("people", "settings"):
            scrolls = "document.documentElement.scrollWidth - document.documentElement.clientWidth"
            assert await page.evaluate(scrolls) == 0
            assert await viewer.probe("cutOff()") == []
            await viewer.button(SETTINGS).click()
            await viewer.lies_still()
