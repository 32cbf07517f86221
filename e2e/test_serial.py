"""From a key in the browser to bytes on a real pseudo-terminal."""

from __future__ import annotations

import asyncio
import time
from collections import Counter
from typing import TYPE_CHECKING, Any, Final

import pytest

from e2e.harness import toml
from e2e.harness.robot import undisturbed, until_it_moves
from e2e.harness.wait import happens, until
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable
    from pathlib import Path

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.board import Board
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer

FOR_GUESTS: Final = str(Sentence("robot.trouble"))


async def the_problem(server: Server) -> str:
    return await server.until(
        lambda told: str(told["robot"]["problem"] or ""), "the server knows of the loss"
    )


def is_connected(status: dict[str, Any]) -> bool:
    return bool(status["robot"]["connected"])


async def hold(
    server: Server, viewer: Viewer, key: str, board: Board, drives: Callable[[], Awaitable[bool]]
) -> None:
    keys = viewer.page.keyboard
    await until_it_moves(
        server,
        lambda: keys.down(key),
        lambda: keys.up(key),
        lambda: happens(drives, within_s=2, every_s=0.02),
        board.greetings,
    )


@pytest.mark.timeout(120)
async def test_a_key_becomes_frames_that_expire_and_wait_for_a_new_press(
    serve: Serve, tmp_path: Path, board: Board, open_viewer: OpenViewer
) -> None:
    """While a key is held, frames of this turn arrive steadily.

    After its release, a loose wire and a pulled plug there are stops, and motion only by a new
    press.
    """

    async def drives() -> bool:
        return board.moves

    async def rests_since(since_s: float) -> None:
        """Check that the server greets the board anew, and then only sends stops."""
        await until(lambda: "hello" in taken(board, since_s), "the server greets the board anew")
        await asyncio.sleep(0.8)
        assert taken(board, since_s) == {"hello", "stop"}, "it moved without a new press"

    def stopped_itself(since_s: float) -> list[float]:
        return [event["t_s"] for event in board.events(since_s) if event["event"] == "ttl"]

    async with serve(tmp_path, toml.card_on(board.path)) as server:
        viewer = await open_viewer(server, drives=True)
        turn = (await server.status())["turn"]["number"]
        keys = viewer.page.keyboard

        seen: list[object] = []

        async def steadily() -> bool:
            """Hold a key for a second; return whether frames came all the time without a stop."""
            await keys.down("ArrowUp")
            if not await happens(drives, within_s=2, every_s=0.02):
                seen.append("it stood")
                await keys.up("ArrowUp")
                return False
            begun_s = time.monotonic()
            await asyncio.sleep(1)
            ended_s = time.monotonic()
            await keys.up("ArrowUp")
            await until(lambda: not board.moves, "its release stops it", within_s=1)
            came = [event for event in board.events(begun_s) if event["event"] == "frame"]
            held = [frame for frame in came if frame["t_s"] < ended_s]
            seen.append(Counter((frame["type"], frame["verdict"]) for frame in came))
            if len(held) < 20 or {frame["type"] for frame in held} != {"drive"}:
                return False
            assert {frame["turn"] for frame in held} == {turn}
            assert {frame["ttl_ms"] for frame in held} == {200}
            assert held[-1]["left"] == held[-1]["right"] > 0
            return {frame["verdict"] for frame in came} == {"taken"}

        came = await undisturbed(server, steadily, board.greetings)
        assert came, f"no frames come steadily: {seen}"
        released_s = time.monotonic()
        await asyncio.sleep(0.3)
        assert taken(board, released_s) - {"hello"} == {"stop"}

        # A line that fails for under half a second stops the robot by its own watchdog.
        await hold(server, viewer, "ArrowUp", board, drives)
        deaf_s = time.monotonic()
        board.deafen(on=True)
        [stopped_s] = await until(
            lambda: stopped_itself(deaf_s), "the watchdog stops it", within_s=1, every_s=0.005
        )
        board.deafen(on=False)
        await rests_since(stopped_s)
        assert is_connected(await server.status())
        await viewer.page.keyboard.up("ArrowUp")

        # The page reports a lost line, which is reopened while the key is still held.
        await hold(server, viewer, "ArrowUp", board, drives)
        await board.unplug()
        await the_problem(server)
        told = viewer.page.get_by_text(FOR_GUESTS)
        await told.first.wait_for(state="visible")
        plugged_s = await board.plug()
        await server.until(is_connected, "the line is opened again")
        await told.first.wait_for(state="hidden")
        await rests_since(plugged_s)
        await viewer.page.keyboard.up("ArrowUp")
        await hold(server, viewer, "ArrowUp", board, drives)
        await viewer.page.keyboard.up("ArrowUp")


def taken(board: Board, since_s: float) -> set[str]:
    frames = [event for event in board.events(since_s) if event["event"] == "frame"]
    return {frame["type"] for frame in frames if frame["verdict"] == "taken"}
