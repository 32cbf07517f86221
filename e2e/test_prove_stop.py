"""`wax prove-stop` on the real firmware: it tells the truth, and leaves the robot standing."""

from __future__ import annotations

import asyncio
import html
import json
import os
import re
from typing import TYPE_CHECKING, Any

import pytest
import tomlkit

from e2e.harness.server import COMMAND
from e2e.harness.wait import until

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from pathlib import Path

    from playwright.async_api import Browser

    from e2e.harness.board import Board

CUTS = 8
SLOW_WATCHDOGS = {
    "drive": {"max_age_ms": 1000.0, "max_command_age_ms": 2000.0},
    "robot": {"silence_ms": 1000, "serial": {"ttl_ms": 1000}},
}
"""The longest that the configuration allows: no watchdog is as fast as the proof demands."""


async def start_proof(folder: Path, board: Board, tree: dict[str, Any] | None = None) -> Process:
    """Start it as the server does for its host; `tree` is the configuration except for the port."""
    tree = tree or {}
    robot = tree.get("robot", {})
    serial = robot.get("serial", {}) | {"url": str(board.path)}
    whole = tree | {"robot": robot | {"driver": "serial", "serial": serial}}
    (folder / "robot.toml").write_text(tomlkit.dumps(whole), encoding="utf-8")
    arguments = ["--config", str(folder / "robot.toml"), "prove-stop", "--lifted", "--json"]
    arguments += ["--repeats", "1", "--record", str(folder / "record.html")]
    return await asyncio.create_subprocess_exec(
        str(COMMAND),
        *arguments,
        env=os.environ | {"XDG_STATE_HOME": str(folder)},
        stdin=asyncio.subprocess.PIPE,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
    )


async def ended(process: Process) -> tuple[bytes, bytes]:
    """Return its output until its end; the pipe to it stays open meanwhile."""
    assert process.stdout is not None
    assert process.stderr is not None
    said = await asyncio.gather(process.stdout.read(), process.stderr.read())
    await process.wait()
    return said


async def prove(folder: Path, board: Board, tree: dict[str, Any] | None = None) -> tuple[int, str]:
    """Run a whole proof; return its status and its record."""
    process = await start_proof(folder, board, tree)
    told, complaint = await ended(process)
    assert not complaint, complaint.decode()
    lines = [json.loads(line) for line in told.splitlines()]
    assert (lines[-1]["done"], lines[-1]["of"]) == (CUTS, CUTS)
    assert process.returncode is not None
    return process.returncode, (folder / "record.html").read_text(encoding="utf-8")


def rows(record: str) -> dict[str, str]:
    """Return each link's result, by its title."""
    lines = [line for line in record.splitlines() if line.startswith("<tr><td>")]
    cells = [line.removesuffix("</td></tr>").split("<td>") for line in lines]
    return {html.unescape(title.partition("</td>")[0]): result for _, title, result in cells}


async def sheets(chromium: Browser, record: str) -> int:
    """Print it on A4; return how many sheets that takes."""
    async with await chromium.new_page() as page:
        await page.set_content(record)
        printed = await page.pdf(format="A4", prefer_css_page_size=True)
    return len(re.findall(rb"/Type\s*/Page\b", printed))


@pytest.mark.full
@pytest.mark.timeout(300)
async def test_a_stop_is_proved_where_it_is_in_time(
    tmp_path: Path, board: Board, chromium: Browser
) -> None:
    """With shipped values each link is cut and each stop is in time; slow watchdogs are late.

    The record is one page, also on paper.
    """
    status, record = await prove(tmp_path, board)
    assert rows(record) == dict.fromkeys(rows(record), "passed"), record
    assert len(rows(record)) == CUTS
    assert "Every link was cut once; the robot stood within " in record
    assert await sheets(chromium, record) == 1
    assert status == 0

    status, record = await prove(tmp_path, board, SLOW_WATCHDOGS)
    late = {title for title, result in rows(record).items() if result == "FAILED"}
    assert late == {
        "The operator's network vanishes",
        "The server is frozen",
        "The driver process is killed",
        "The serial line is cut",
    }, record
    assert "Not proved: too late, or no stop at all: " in record
    assert await sheets(chromium, record) == 1
    assert status == 1


@pytest.mark.timeout(120)
async def test_broken_off_it_leaves_a_robot_that_stands(tmp_path: Path, board: Board) -> None:
    """Its parent's end stops the robot in the middle, and it says that it proved nothing."""
    process = await start_proof(tmp_path, board)
    await until(lambda: board.moves, "the robot is driven", within_s=60, every_s=0.02)
    assert process.stdin is not None
    process.stdin.close()
    _, complaint = await asyncio.wait_for(ended(process), 40)
    assert not complaint, complaint.decode()
    assert process.returncode == 1
    assert not board.moves
    record = (tmp_path / "record.html").read_text(encoding="utf-8")
    assert "Not proved: it was aborted." in record
