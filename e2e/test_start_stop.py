"""How the server begins with what `wax init` wrote, and ends while nobody reads its log."""

from __future__ import annotations

import asyncio
import os
import pty
import signal
from typing import TYPE_CHECKING

import pytest
from tests.full_pipe import full_pipe

from e2e.harness import toml
from e2e.harness.robot import turn_by_key
from e2e.harness.server import COMMAND, Server

if TYPE_CHECKING:
    from pathlib import Path

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.board import Board


@pytest.mark.full
@pytest.mark.timeout(90)
async def test_a_paused_standard_error_stops_nothing(
    tmp_path: Path, open_viewer: OpenViewer
) -> None:
    """While nobody reads its log the server answers, drives, and Ctrl-C ends it as ever."""
    with full_pipe() as stderr:
        async with Server(tmp_path, toml.CARD, stderr=stderr) as server:
            viewer = await open_viewer(server, drives=True)
            await turn_by_key(server, viewer)
            await server.stop(signal.SIGINT)


async def _at_a_terminal(folder: Path, *arguments: str) -> tuple[int, str]:
    """Run `wax` with a terminal of its own; return its exit status and what it said."""
    ours, theirs = pty.openpty()
    try:
        process = await asyncio.create_subprocess_exec(
            str(COMMAND), *arguments, stdin=theirs, stdout=theirs, stderr=theirs, cwd=folder
        )
        code = await asyncio.wait_for(process.wait(), 40)
        os.set_blocking(ours, False)
        return code, os.read(ours, 65536).decode()
    finally:
        os.close(theirs)
        os.close(ours)


@pytest.mark.full
async def test_what_init_writes_drives_a_board(serve: Serve, tmp_path: Path, board: Board) -> None:
    """With --yes and a board plugged in, the file that is written starts a server that has it.

    This machine has no camera: the page says so, and the microphone's absence is no problem.
    """
    path = tmp_path / "robot.toml"
    code, said = await _at_a_terminal(
        tmp_path, "init", "--yes", "--serial", str(board.path), "robot.toml"
    )
    assert code == 0, said
    assert f"the board on {board.path}" in said
    async with serve(tmp_path, path.read_text(encoding="utf-8")) as server:
        what = "the server talks to the board"
        await server.until(lambda told: told["robot"]["connected"], what, within_s=10)
        status = await server.status()
        assert status["robot"]["kind"] == "serial"
        video = status["streams"]["video"]
        assert video["captured_fps"] or "No camera was found" in video["problem"]
    again, said = await _at_a_terminal(tmp_path, "init", "--yes", "robot.toml")
    assert again == 2
    assert "is there already" in said
