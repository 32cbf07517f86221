"""How the server ends while somebody drives."""

from __future__ import annotations

import asyncio
import signal
from typing import TYPE_CHECKING

import pytest
from tests.full_pipe import full_pipe

from e2e.harness import toml
from e2e.harness.line import SerialLine
from e2e.harness.robot import turn_by_key
from e2e.harness.server import Server
from e2e.harness.wait import eventually

if TYPE_CHECKING:
    from pathlib import Path

    from e2e.conftest import OpenViewer, Serve


@pytest.mark.timeout(60)
async def test_the_robot_is_stopped_before_the_end(
    serve: Serve, tmp_path: Path, open_viewer: OpenViewer
) -> None:
    """The last byte on the line is a stop when the server is ended while somebody drives."""
    line = SerialLine(tmp_path)
    line.plug()
    try:
        settings = toml.card_with(
            robot='driver = "serial"', robot__serial=f'url = "{line.path}"\ndialect = "bytes"'
        )
        async with serve(tmp_path, settings) as server:
            viewer = await open_viewer(server, drives=True)

            async def drives() -> bool:
                """Press; what is pressed before the turn's first neutral command moves nothing."""
                await viewer.page.keyboard.up("ArrowUp")
                await viewer.page.keyboard.down("ArrowUp")
                await asyncio.sleep(0.5)
                return line.received.endswith(b"F")

            await eventually(drives, "the robot drives")
            await server.stop(signal.SIGTERM)
            await asyncio.sleep(0.1)
            assert line.received.endswith(b"S")
    finally:
        line.unplug()


@pytest.mark.timeout(90)
async def test_a_paused_standard_error_stops_nothing(
    tmp_path: Path, open_viewer: OpenViewer
) -> None:
    """While nobody reads its log the server answers, drives, and Ctrl-C ends it as ever."""
    with full_pipe() as stderr:
        server = Server(tmp_path, toml.CARD, stderr=stderr)
        try:
            await server.start()
            viewer = await open_viewer(server, drives=True)
            await turn_by_key(server, viewer)
            await server.stop(signal.SIGINT)
        finally:
            await server.kill()
