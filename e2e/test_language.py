"""The page speaks the reader's language, and can be used in one that is longer and mirrored."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import pytest
import pytest_asyncio
from playwright.async_api import expect

from e2e.harness import toml

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from playwright.async_api import FloatRect, Locator, Page

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.server import Server

SIZES = ((390, 844), (844, 390), (1280, 800))
"""A phone held upright and across, and a large window."""

STOP = re.compile(r"^\W*Šţö+p")
SETTINGS = re.compile(r"^\W*Šé+ţ")
JOIN = re.compile(r"^\W*Ĵö+î+ñ")
LEFT = re.compile(r"^\W*Ļé+f")
RIGHT = re.compile(r"^\W*Ŕî+ĝ")
"""As the trial language writes them."""

CUT_OFF = """() => [...document.querySelectorAll("button, input, select")].filter((one) => {
    const { left, right, width } = one.getBoundingClientRect();
    if (width === 0) return false;
    for (let around = one.parentElement; around; around = around.parentElement) {
        const box = around.getBoundingClientRect();
        const isOpen = around !== document.documentElement
            && getComputedStyle(around).overflowX === "visible";
        if (!isOpen && (left < box.left - 1 || right > box.right + 1)) return true;
    }
    return false;
}).map((one) => one.outerHTML)"""
"""The controls of which a part lies outside of what holds them, or of the page."""


@pytest_asyncio.fixture(scope="module", loop_scope="session")
async def server(serve: Serve, tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[Server]:
    settings = toml.card_with(turns=toml.BRIEF_GRACE)
    async with serve(tmp_path_factory.mktemp("language"), settings) as running:
        yield running


def _button(page: Page, name: str | re.Pattern[str]) -> Locator:
    return page.get_by_role("button", name=name, exact=True)


async def _box(locator: Locator) -> FloatRect:
    box = await locator.bounding_box()
    assert box is not None, f"{locator} is not shown"
    return box


async def _is_in(page: Page, language: str) -> None:
    await expect(page.locator("html")).to_have_attribute("lang", language)


@pytest.mark.timeout(60)
async def test_the_browsers_language_is_the_pages(server: Server, open_viewer: OpenViewer) -> None:
    """Who has a German browser reads German, and who does not reads English."""
    german = await open_viewer(server, locale="de-AT")
    await _is_in(german.page, "de")
    await expect(_button(german.page, "Stopp")).to_be_visible()
    french = await open_viewer(server, locale="fr-FR")
    await _is_in(french.page, "en")
    await expect(_button(french.page, "Stop")).to_be_visible()


@pytest.mark.timeout(60)
async def test_the_address_chooses_the_language(server: Server, open_viewer: OpenViewer) -> None:
    """A link with `?lang=de` opens a German page in any browser, and Stop stops there too."""
    viewer = await open_viewer(server)
    await viewer.page.goto(f"{server.url}/?lang=de")
    await viewer.sees_picture()
    await _is_in(viewer.page, "de")
    await _button(viewer.page, "Stopp").click()
    await expect(viewer.page.get_by_text("Du hast den Roboter gestoppt")).to_be_visible()


@pytest.mark.timeout(60)
async def test_a_chosen_language_stays_chosen(server: Server, open_viewer: OpenViewer) -> None:
    """What is chosen in the settings is spoken at once, and again at the next visit."""
    page = (await open_viewer(server)).page
    await _button(page, "Settings").click()
    await page.get_by_role("combobox", name="Language", exact=True).select_option("Deutsch")
    await expect(_button(page, "Stopp")).to_be_visible()
    await page.reload()
    await _is_in(page, "de")
    await expect(_button(page, "Stopp")).to_be_visible()


@pytest.mark.timeout(60)
@pytest.mark.parametrize(("width", "height"), SIZES)
async def test_a_long_language_from_right_to_left_keeps_the_page_usable(
    server: Server, open_viewer: OpenViewer, width: int, height: int
) -> None:
    """In a mirrored language, two fifths longer, nothing is cut off and left is still left."""
    viewer = await open_viewer(server, viewport={"width": width, "height": height})
    page = viewer.page
    await page.goto(f"{server.url}/?lang=pseudo")
    await viewer.sees_picture()
    await expect(page.locator("html")).to_have_attribute("dir", "rtl")
    await _button(page, JOIN).click()
    await expect(_button(page, LEFT)).to_be_visible()
    left, right = await _box(_button(page, LEFT)), await _box(_button(page, RIGHT))
    assert left["x"] + left["width"] <= right["x"]
    stop = await _box(_button(page, STOP))
    assert stop["y"] >= 0
    assert stop["y"] + stop["height"] <= height
    for _panel in ("people", "settings"):
        scrolls = "document.documentElement.scrollWidth - document.documentElement.clientWidth"
        assert await page.evaluate(scrolls) == 0
        assert await page.evaluate(CUT_OFF) == []
        await _button(page, SETTINGS).click()
