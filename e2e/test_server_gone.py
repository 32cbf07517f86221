"""What the page shows when its server pauses, dies or restarts, and that it reconnects."""

from __future__ import annotations

import os
import signal
from typing import TYPE_CHECKING

import pytest
from playwright.async_api import expect

from e2e.harness import toml
from e2e.harness.probe import assert_live
from e2e.harness.robot import turn_by_key
from e2e.harness.wait import eventually
from wax.clock import SystemClock

if TYPE_CHECKING:
    from pathlib import Path

    from e2e.conftest import OpenViewer, Serve

pytestmark = pytest.mark.timeout(120)


SAID_WITHIN_MS = 1000
"""A safety deadline: the operator must not mistake an old picture for a live one."""
STOP_SAID_WITHIN_MS = 2000
"""A safety deadline, too: until then somebody believes that the robot has stopped."""
TOLD_AFTER_MS = """() => new Promise((resolve) => {
    const pressedMs = performance.now();
    new MutationObserver(() => {
        const told = document.querySelector('[role="alert"]')?.textContent ?? "";
        if (told.includes("Stop is not confirmed")) resolve(performance.now() - pressedMs);
    }).observe(document.body, { childList: true, subtree: true });
    const button = [...document.querySelectorAll("button")].find((one) => one.innerText === "Stop");
    button.dispatchEvent(new PointerEvent("pointerdown", { bubbles: true }));
})"""


async def test_a_server_that_is_gone_is_told_within_a_second_and_found_again(
    serve: Serve, tmp_path: Path, open_viewer: OpenViewer
) -> None:
    """A paused server is not called lost; after a kill the picture is grey until it is back.

    The page reconnects with its name and drives; if a server is stopped, the page says so.
    """
    async with serve(tmp_path, toml.CARD) as server:
        viewer = await open_viewer(server, drives=True)
        await viewer.call_oneself("Ada")
        # A page that drives pings often for its first second, then each 200 ms. Its patience is the
        # slowest of its last five answers, and a pause delays some of them.
        await viewer.probe("after(1500)")
        peers = await viewer.probe("peers()")

        async def is_live() -> bool:
            return await viewer.says_connected() and not await viewer.probe("isGrey()")

        for end in (signal.SIGSTOP, signal.SIGKILL):
            await eventually(is_live, "the page says that it is connected, and shows it")
            await viewer.probe("noteChange()")
            ended_ms = SystemClock().wall_ms()
            os.kill(server.pid, end)
            at_ms, said = await viewer.probe("said()")
            assert said == "No answer for 1 s"
            assert await viewer.probe("isGrey()")
            assert at_ms - ended_ms < SAID_WITHIN_MS
            if end == signal.SIGSTOP:  # after two seconds it is called lost
                os.kill(server.pid, signal.SIGCONT)
                await eventually(is_live, "the page says that it is connected, and shows it")
                assert await viewer.probe("peers()") == peers
                await viewer.probe("after(1500)")
        await viewer.probe("notLive()")
        await server.kill()
        await server.start()
        await server.until(lambda told: len(told["viewers"]) == 1, "the page is back", within_s=40)
        await viewer.sees_picture()
        assert_live(await viewer.cards(20))
        assert [line["name"] for line in (await server.status())["viewers"]] == ["Ada"]
        await viewer.takes_the_wheel()
        await turn_by_key(server, viewer)
        await viewer.page.keyboard.up("ArrowLeft")
        await viewer.probe("noteChange()")
        await server.stop(signal.SIGTERM)
        _, said = await viewer.probe("said()")
        assert "The server is restarting or was switched off." in said


async def test_a_stop_into_a_dead_line_says_so_within_two_seconds_until_it_is_taken(
    serve: Serve, tmp_path: Path, open_viewer: OpenViewer
) -> None:
    """Nobody keeps believing in a Stop that did not arrive; the page itself delivers it later."""
    async with serve(tmp_path, toml.CARD) as server:
        viewer = await open_viewer(server)
        page = viewer.page
        os.kill(server.pid, signal.SIGSTOP)
        told_ms = await page.evaluate(TOLD_AFTER_MS)
        assert told_ms < STOP_SAID_WITHIN_MS
        assert await viewer.button("Stop").is_enabled()
        os.kill(server.pid, signal.SIGCONT)
        await server.until(lambda told: told["stop"] is not None, "the robot is stopped")
        await expect(page.get_by_role("alert")).to_have_count(0, timeout=20_000)
        await expect(page.get_by_text("You stopped the robot")).to_be_visible(timeout=20_000)
