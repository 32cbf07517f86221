"""Details on demand: the reason for slowness, plots and figures, loaded when somebody asks."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import pytest
from playwright.async_api import expect

from e2e.harness.wait import eventually

if TYPE_CHECKING:
    from pathlib import Path

    from playwright.async_api import Route

    from e2e.conftest import OpenViewer
    from e2e.harness.server import Server

PLOTS = 7
PLOTS_BUTTON = "Plots, and why it is slow"


@pytest.mark.full
@pytest.mark.timeout(90)
async def test_details_show_what_was_measured_before_they_were_asked_for(
    server: Server, open_viewer: OpenViewer, tmp_path: Path
) -> None:
    """The past is there at once, in plots and tables, within the policy, and can be saved.

    If the file does not load, a sentence says so; watching continues, and the file is requested
    again.
    """
    viewer = await open_viewer(server)
    page = viewer.page
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))

    async def refuse(route: Route) -> None:
        await route.abort()

    await page.route("**/StatsPage*", refuse)
    await viewer.probe("after(5000)")  # it keeps what it measures once a second
    assert not [url for url in asked if "StatsPage" in url]
    await viewer.open("Details")
    details = viewer.button(PLOTS_BUTTON)
    await details.focus()
    await page.keyboard.press("Enter")
    alert = page.get_by_role("alert").filter(has_text="could not be loaded")
    await expect(alert).to_be_visible()
    assert await viewer.says_connected()
    await viewer.sees_picture()
    # The file and its style are requested at once; the second refusal may still be in flight.
    await page.unroute_all(behavior="wait")
    asked.clear()
    await viewer.button("Try again").press("Enter")
    await expect(page.get_by_role("heading", name="Why is it slow?")).to_be_visible()
    assert [url for url in asked if "StatsPage" in url]
    await expect(page.get_by_role("table")).to_have_count(PLOTS)
    row = page.get_by_role("row").filter(
        has=page.get_by_role("rowheader", name="picture", exact=True)
    )
    ages = await row.get_by_role("cell").all_inner_texts()
    assert all(int(age) < 2000 for age in ages), ages

    async def is_drawn() -> bool:
        inked = await viewer.probe("inked()")
        return len(inked) == PLOTS and all(inked)

    await eventually(is_drawn, "every plot is drawn")
    async with page.expect_download() as saving:
        await viewer.button("Save for a bug report").click()
    saved = tmp_path / "saved.json"
    await (await saving.value).save_as(saved)
    told = json.loads(saved.read_text(encoding="utf-8"))
    assert (told["schema"], told["schema_version"], told["role"]) == ("wax-stats", 1, "observer")
    assert len(told["samples"]["picture_ms"]) == len(told["samples"]["age_ms"]) > 3
    assert any(mark["kind"] == "link" for mark in told["marks"])
    assert "127.0.0.1" not in saved.read_text(encoding="utf-8")
    refused = [line for line in viewer.console if "Content Security Policy" in line]
    assert not refused, refused
