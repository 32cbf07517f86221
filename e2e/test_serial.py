"""From a key in the browser to bytes on a real pseudo-terminal."""

from __future__ import annotations

import asyncio
import contextlib
import time
from functools import partial
from operator import contains
from typing import TYPE_CHECKING, Any, Final

import pytest
import pytest_asyncio

from e2e.harness import toml
from e2e.harness.commands import become_host
from e2e.harness.line import SerialLine
from e2e.harness.robot import until_it_moves
from e2e.harness.wait import until
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable
    from pathlib import Path

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.board import Board
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer

FOR_GUESTS: Final = str(Sentence("robot.trouble"))


@pytest_asyncio.fixture(loop_scope="session")
async def line(tmp_path: Path) -> AsyncIterator[SerialLine]:
    with SerialLine(tmp_path) as cable:
        yield cable


async def the_problem(server: Server) -> str:
    return await server.until(
        lambda told: str(told["robot"]["problem"] or ""), "the server knows of the loss", within_s=3
    )


def is_connected(status: dict[str, Any]) -> bool:
    return bool(status["robot"]["connected"])


async def hold(server: Server, viewer: Viewer, key: str, drives: Callable[[], bool]) -> None:
    keys = viewer.page.keyboard

    async def is_moving() -> bool:
        with contextlib.suppress(AssertionError):  # then whoever asked says so
            return await until(drives, "the robot moves", within_s=1.5, every_s=0.02)
        return False

    await until_it_moves(server, lambda: keys.down(key), lambda: keys.up(key), is_moving)


@pytest.mark.timeout(90)
async def test_a_key_becomes_one_byte_and_its_release_another(
    serve: Serve, tmp_path: Path, line: SerialLine, open_viewer: OpenViewer
) -> None:
    """In the dialect of 2004 each press is one byte, sent on change, and the release is a stop."""
    async with serve(tmp_path, toml.card_on(line.path, "bytes")) as server:
        viewer = await open_viewer(server, drives=True)
        for key, octet in (("ArrowUp", b"F"), ("s", b"B"), ("ArrowLeft", b"L"), ("d", b"R")):
            await asyncio.sleep(0.3)
            line.forget()
            await hold(server, viewer, key, partial(contains, line.received, octet))
            assert b"S" not in line.received[line.received.rindex(octet) :]
            line.forget()
            await viewer.page.keyboard.up(key)
            await until(lambda: b"S" in line.received, "a stop comes down the line", within_s=2)


@pytest.mark.timeout(120)
async def test_a_key_becomes_frames_that_expire_and_wait_for_a_new_press(
    serve: Serve, tmp_path: Path, board: Board, open_viewer: OpenViewer
) -> None:
    """While it is held frames of this turn come steadily; after its release, a loose wire and a
    pulled plug there are stops, and motion only by a new press.
    """

    def drives() -> bool:
        return board.moves

    def stopped_itself() -> bool:
        return any(event["event"] == "ttl" for event in board.events())

    async with serve(tmp_path, toml.card_on(board.path, "frames")) as server:
        viewer = await open_viewer(server, drives=True)
        turn = (await server.status())["turn"]["number"]
        await hold(server, viewer, "ArrowUp", drives)
        await asyncio.sleep(0.3)
        begun_s = time.monotonic()
        await asyncio.sleep(1)
        ended_s = time.monotonic()
        await viewer.page.keyboard.up("ArrowUp")
        await asyncio.sleep(0.5)

        frames = [event for event in board.events(begun_s) if event["event"] == "frame"]
        held = [frame for frame in frames if frame["t_s"] < ended_s]
        released = [frame for frame in frames if frame["t_s"] > ended_s]
        assert {frame["verdict"] for frame in frames} == {"taken"}
        assert {frame["type"] for frame in held} == {"drive"}
        assert len(held) >= 20, f"only {len(held)} frames in a second"
        assert {frame["turn"] for frame in held} == {turn}
        assert {frame["ttl_ms"] for frame in held} == {200}
        assert held[-1]["left"] == held[-1]["right"] > 0
        assert {frame["type"] for frame in released[-5:]} == {"stop"}
        assert not board.moves

        # A line that fails for under half a second stops the robot by its own watchdog.
        await hold(server, viewer, "ArrowUp", drives)
        board.deafen(on=True)
        await until(stopped_itself, "the watchdog stops it", within_s=1, every_s=0.005)
        board.deafen(on=False)
        await asyncio.sleep(1.5)
        (stopped_s,) = (event["t_s"] for event in board.events() if event["event"] == "ttl")
        assert taken(board, stopped_s) == {"hello", "stop"}, "it moved without a new press"
        assert is_connected(await server.status())
        await viewer.page.keyboard.up("ArrowUp")

        # The page reports a lost line, which is opened again while the key is still held.
        await asyncio.sleep(0.2)
        await hold(server, viewer, "ArrowUp", drives)
        await board.unplug()
        await the_problem(server)
        told = viewer.page.get_by_text(FOR_GUESTS)
        await told.first.wait_for(state="visible", timeout=2000)
        plugged_s = await board.plug()
        await server.until(is_connected, "the line is opened again", within_s=5)
        await told.first.wait_for(state="hidden", timeout=2000)
        await asyncio.sleep(1)
        assert taken(board, plugged_s) == {"hello", "stop"}, "it moved without a new press"
        await viewer.page.keyboard.up("ArrowUp")
        await asyncio.sleep(0.2)
        await hold(server, viewer, "ArrowUp", drives)
        await viewer.page.keyboard.up("ArrowUp")


def taken(board: Board, since_s: float) -> set[str]:
    frames = [event for event in board.events(since_s) if event["event"] == "frame"]
    return {frame["type"] for frame in frames if frame["verdict"] == "taken"}


@pytest.mark.timeout(90)
async def test_a_robot_that_is_missing_or_deaf_is_told(
    serve: Serve, tmp_path: Path, board: Board, open_viewer: OpenViewer
) -> None:
    """With none plugged in the picture plays; the host reads what to check, a guest does not."""
    await board.unplug()
    async with serve(tmp_path, toml.card_on(board.path, "frames")) as server:
        viewer = await open_viewer(server)
        assert not is_connected(await server.status())
        sentence = await the_problem(server)
        assert str(board.path) in sentence
        await viewer.page.get_by_text(FOR_GUESTS).first.wait_for(timeout=3000)
        assert await viewer.page.get_by_text(str(board.path)).count() == 0
        await become_host(viewer, server)
        await viewer.page.get_by_text(sentence).first.wait_for(timeout=3000)
        await board.plug()
        await server.until(is_connected, "the robot is found", within_s=5)
        board.deafen(on=True)
        sentence = await the_problem(server)
        await viewer.page.get_by_text(sentence).first.wait_for(timeout=2000)
        board.deafen(on=False)
        await server.until(is_connected, "the board answers again", within_s=5)
