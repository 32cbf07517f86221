"""A person aboard, as everybody's page shows them."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import pytest
from playwright.async_api import expect

from e2e.harness.wait import eventually

if TYPE_CHECKING:
    from e2e.conftest import OpenViewer
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer

SERVER_SETTINGS = """
[local]
source = "robot"
pause_s = 0.5
script_s = 5.0
script = [
    { at_s = 0.5, for_s = 0.3, press = "wait" },
    { at_s = 2.0, for_s = 1.0, linear = -0.6 },
]
"""
"""Somebody who asks the operator to wait, and then drives back by themselves, again and again."""


@pytest.mark.timeout(90)
async def test_the_person_aboard_asks_and_takes_over(
    server: Server, driver: Viewer, open_viewer: OpenViewer
) -> None:
    """Everybody reads it; the operator, who holds a key, drives again only after releasing it."""
    page, watching = driver.page, await open_viewer(server)
    await expect(page.get_by_role("alert").first).to_contain_text("Please wait.", timeout=30_000)
    await page.keyboard.down("ArrowUp")
    await server.until(
        lambda told: told["robot"]["speed_mps"] < -0.02,
        "the person aboard drives back",
        within_s=20,
    )
    for one in (page, watching.page):
        words = one.get_by_text(re.compile("The person aboard is driving"))
        await expect(words.first).to_be_visible(timeout=20_000)  # at the latest the next time
    await page.keyboard.up("ArrowUp")

    async def goes_ahead() -> bool:
        await page.keyboard.up("ArrowUp")
        await page.keyboard.down("ArrowUp")
        return bool((await server.status())["robot"]["speed_mps"] > 0.02)

    await eventually(goes_ahead, "the operator drives again", within_s=20, every_s=0.4)
    await page.keyboard.up("ArrowUp")
