"""`wax glass`: the delay from camera to screen, by a time code that the camera films."""

from __future__ import annotations

import re
import time
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
import pytest
from playwright.async_api import expect

from e2e.harness.commands import said_by
from e2e.harness.time_code import PERIOD_MS, read_straight
from e2e.harness.viewer import Viewer
from e2e.harness.wait import eventually

if TYPE_CHECKING:
    from pathlib import Path

    from playwright.async_api import Browser, Page

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.server import Server

SCREEN: dict[str, Any] = {"viewport": {"width": 1280, "height": 800}}
REPEATS_MS = 256 * PERIOD_MS
WITHIN_S = 10


async def figure(page: Page, name: str) -> int:
    """Return the number beside this name, 0 without one."""
    value = page.locator("dt", has_text=name).locator("xpath=following-sibling::dd[1]")
    found = re.match(r"-?\d+", (await value.inner_text()).replace(",", ""))
    return int(found.group()) if found else 0


@pytest.mark.timeout(120)
@pytest.mark.parametrize(
    ("camera", "late_ms"),
    [
        pytest.param("FilmedCode", 0, marks=pytest.mark.full),
        ("Late40", 40),
        pytest.param("Late120", 120, marks=pytest.mark.full),
    ],
)
async def test_the_camera_s_own_delay_is_found_and_kept(
    serve: Serve, open_viewer: OpenViewer, tmp_path: Path, camera: str, late_ms: int
) -> None:
    """30 pictures are read in 10 s, and say it to 5 ms; the host keeps it, and Details adds it."""
    settings = f'[video]\nsource = "e2e.harness.time_code:{camera}"\n[audio]\nsource = "testcard"\n'
    async with serve(tmp_path, settings) as server:
        viewer = await open_viewer(server, is_host=True, **SCREEN)
        page = viewer.page
        await page.goto(f"{server.url}/?view=glass")
        await viewer.sees_picture()

        async def are_read() -> bool:
            return await figure(page, "Pictures read") >= 30

        await eventually(are_read, "30 pictures are read", within_s=WITHIN_S)
        rest_ms = await figure(page, "Camera, exposure and screen")
        assert rest_ms == pytest.approx(late_ms, abs=5)
        total_ms = await figure(page, "Camera to screen")
        known_ms = await figure(page, "WAX: capture to display")
        assert total_ms > late_ms
        assert total_ms <= await figure(page, "95 % are below")
        await page.get_by_role("button", name=re.compile(r"^Keep \d+ ms")).click()
        kept = page.get_by_text("Details adds")
        await expect(kept).to_be_visible()
        kept_ms = int(re.findall(r"\d+", await kept.inner_text())[0])
        assert kept_ms == pytest.approx(late_ms, abs=5)
        await page.goto(server.url)
        await viewer.sees_picture()
        await viewer.open("Details")
        added_ms = await eventually(
            lambda: figure(page, "With camera and screen"), "Details adds it"
        )
        assert added_ms >= kept_ms
        assert known_ms > 0


async def test_the_code_s_page_shows_the_server_s_time(server: Server, chromium: Browser) -> None:
    """It fills the window and nothing else is on it; `wax glass` prints its address."""
    printed = await said_by(server.log_path.parent, "glass", **server.environment)
    address = next(line for line in printed.split() if line.endswith("?view=glass&only=code"))
    assert f"{server.url}/?view=glass#host=" in printed
    async with await chromium.new_context(**SCREEN) as context:
        viewer = await Viewer.at(context, address)
        page = viewer.page
        await expect(page.get_by_role("img", name="Time code")).to_be_visible()

        async def ahead_ms() -> float | None:
            before_ms = time.monotonic() * 1000
            shot = await page.screenshot()
            after_ms = time.monotonic() * 1000
            grey = cv2.imdecode(np.frombuffer(shot, np.uint8), cv2.IMREAD_GRAYSCALE)
            assert grey is not None
            shown_ms = read_straight(grey.astype(np.uint8))
            if shown_ms is None:
                return None
            since_ms = (shown_ms - before_ms + 1000) % REPEATS_MS - 1000
            return since_ms if -200 < since_ms < after_ms - before_ms + 200 else None

        await eventually(ahead_ms, "the page shows the time of now")
