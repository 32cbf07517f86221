"""The host's button "Prove the stop": the robot is lent, anybody can stop it, it comes back."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest

from e2e.harness import toml
from e2e.harness.wait import eventually

if TYPE_CHECKING:
    from pathlib import Path

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.board import Board


@pytest.mark.full
@pytest.mark.timeout(120)
async def test_a_proof_from_the_page_drives_until_somebody_stops_it(
    serve: Serve, tmp_path: Path, board: Board, open_viewer: OpenViewer
) -> None:
    """The page follows the proof, an observer's Stop ends it, and the robot is available again."""
    robot = f'url = "{board.path}"'
    settings = toml.card_with(robot='driver = "serial"', robot__serial=robot)
    async with serve(tmp_path, settings) as server:
        host, other = await open_viewer(server, is_host=True), await open_viewer(server)
        await other.join()
        await other.drives()

        await host.page.get_by_role("button", name="Host", exact=True).click()
        await host.page.get_by_text("Prove the stop…").click()
        assert await host.button("Prove it now").is_disabled()
        await host.page.get_by_label("The wheels are off the floor").check()
        await host.button("Prove it now").click()
        proof = host.page.get_by_role("status", name="Proof", exact=True)
        await proof.filter(has_text="of 40").wait_for(timeout=20_000)
        await other.page.get_by_text("The host is testing the stop").first.wait_for()

        async def moves() -> bool:
            return board.moves

        await eventually(moves, "the proof drives", within_s=60, every_s=0.02)
        await other.button("Stop").click()
        await asyncio.sleep(0.5)
        assert not board.moves
        await proof.filter(has_text="Someone pressed Stop").wait_for(timeout=15_000)
        assert not board.moves
        record = await host.page.get_by_text("Open the record").get_attribute("href")
        assert record is not None
        text = await (await host.page.request.get(f"{server.url}/{record}")).text()
        assert "Not proved: it was aborted." in text

        await other.release_stop()
        for _ in range(3):  # a busy machine may ask for a new press
            await other.page.keyboard.down("ArrowUp")
            await asyncio.sleep(1)
            if board.moves:
                break
            await other.page.keyboard.up("ArrowUp")
        assert board.moves
        await other.page.keyboard.up("ArrowUp")
