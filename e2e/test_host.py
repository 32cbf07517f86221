"""The host's page: the link that makes it, and what the others see of its acts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from e2e.harness import toml
from e2e.harness.host import become_host

if TYPE_CHECKING:
    from pathlib import Path

    from e2e.conftest import OpenViewer, Serve


@pytest.mark.timeout(120)
async def test_a_host_blanks_the_picture_removes_a_troll_and_closes(
    serve: Serve, tmp_path: Path, open_viewer: OpenViewer
) -> None:
    """Each act of the host reaches the others' pages in words, and who is removed stays away."""
    async with serve(tmp_path, toml.CARD) as server:
        host, troll = await open_viewer(server), await open_viewer(server)
        assert await host.page.get_by_role("button", name="Host", exact=True).count() == 0
        await become_host(host, server)
        assert host.page.url == f"{server.url}/"
        await troll.call_oneself("Troll")
        await host.page.get_by_role("button", name="Host", exact=True).click()

        blank = host.switch("Picture and sound off for everybody")
        await blank.click()
        await troll.page.get_by_text("The host has switched picture and sound off").wait_for()
        await blank.click()
        await troll.sees_picture()

        line = host.page.locator(".person", has_text="Troll")
        await line.get_by_role("button", name="Remove…").click()
        await line.get_by_role("button", name="Remove", exact=True).click()
        await troll.page.get_by_role("heading", name="The host has asked you to leave.").wait_for()
        await line.wait_for(state="hidden")
        await troll.button("Try again").click()
        await troll.sees_picture()

        await host.button("Close for today…").click()
        await host.button("Close").click()
        await troll.page.get_by_role("heading", name="The robot is closed.").wait_for()
        await troll.button("Try again").click()
        await troll.page.get_by_role("heading", name="The robot is closed.").wait_for()
