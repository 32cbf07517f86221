"""Starting where one cannot, and stopping."""

from __future__ import annotations

import asyncio
import signal
import socket
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


async def refuses_to_start(server: Server) -> str:
    """Return its output; it must exit on its own, with a failure and without a traceback."""
    await server.launch()
    try:
        code = await server.exit_code(within_s=10)
    finally:
        await server.kill()
    assert code != 0
    assert "Traceback" not in server.log
    return server.log


@pytest.mark.timeout(30)
async def test_a_taken_port_is_told(tmp_path: Path) -> None:
    """Where another program has the port, the server ends with one sentence that names it."""
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        said = await refuses_to_start(Server(tmp_path, toml.CARD, port=port))
    assert str(port) in said
    assert len(said.strip().splitlines()) <= 3, said


@pytest.mark.timeout(30)
async def test_a_wrong_configuration_is_told_in_full(tmp_path: Path) -> None:
    """Every problem of the file is named at once: the key, what it got, what is allowed."""
    wrong = '[turns]\nturn_s = -1\nturns = 3\n[video]\ncodec = "theora"\n'
    said = await refuses_to_start(Server(tmp_path, wrong))
    for word in ("wax.toml", "turns.turn_s", "-1", "turns.turns", "video.codec", "theora"):
        assert word in said, said


@pytest.mark.timeout(60)
@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGINT], ids=["SIGTERM", "Ctrl-C"])
async def test_it_ends_within_three_seconds_with_a_viewer_there(
    serve: Serve, tmp_path: Path, open_viewer: OpenViewer, how: signal.Signals
) -> None:
    """SIGTERM and Ctrl-C end the server in time, exit status 0, though somebody watches."""
    async with serve(tmp_path, toml.CARD) as server:
        await open_viewer(server)
        await server.stop(how)


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
            viewer = await open_viewer(server)
            await viewer.join()
            await viewer.drives()

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
    """While nobody reads its log the server answers, drives, and ends as ever."""
    with full_pipe() as stderr:
        server = Server(tmp_path, toml.CARD, stderr=stderr)
        try:
            await server.start()
            viewer = await open_viewer(server)
            await viewer.join()
            await viewer.drives()
            await turn_by_key(server, viewer)
            await server.stop(signal.SIGTERM)
        finally:
            await server.kill()
