"""How the server starts with the file that `wax init` wrote."""

from __future__ import annotations

import asyncio
import os
import pty
from typing import TYPE_CHECKING

import pytest

from e2e.harness.server import COMMAND

if TYPE_CHECKING:
    from pathlib import Path

    from e2e.conftest import Serve
    from e2e.harness.board import Board


async def _at_a_terminal(folder: Path, *arguments: str) -> tuple[int, str]:
    """Run `wax` with a terminal of its own; return its exit status and its output."""
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
    """With --yes and a board plugged in, the written file starts a server that drives the board.

    This machine has no camera: the page says so, and the missing microphone is no problem.
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
