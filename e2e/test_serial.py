"""From a key in the browser to bytes on a real pseudo-terminal."""

from __future__ import annotations

import asyncio
import os
import pty
import signal
import time
import tty
from collections import Counter
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final

import pytest

from e2e.harness import toml
from e2e.harness.robot import undisturbed, until_it_moves
from e2e.harness.wait import eventually, happens, until
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Iterator
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
    server: Server, viewer: Viewer, key: str, drives: Callable[[], Awaitable[bool]]
) -> None:
    keys = viewer.page.keyboard
    await until_it_moves(
        server,
        lambda: keys.down(key),
        lambda: keys.up(key),
        lambda: happens(drives, within_s=2, every_s=0.02),
    )


@contextmanager
def serial_line(port: Path) -> Iterator[bytearray]:
    """Have a pseudo-terminal behind a name of our own; gives what has come down it so far."""
    ours, theirs = pty.openpty()
    tty.setraw(theirs)
    port.symlink_to(os.ttyname(theirs))
    loop, received = asyncio.get_running_loop(), bytearray()
    loop.add_reader(ours, lambda: received.extend(os.read(ours, 4096)))
    try:
        yield received
    finally:
        loop.remove_reader(ours)
        os.close(ours)
        os.close(theirs)


def ends_with(octet: bytes, received: bytearray) -> Callable[[], Awaitable[bool]]:
    """Ask whether this is the newest byte."""

    async def so() -> bool:
        return received.endswith(octet)

    return so


@pytest.mark.full
@pytest.mark.timeout(90)
async def test_a_key_becomes_one_byte_and_its_release_another(
    serve: Serve, tmp_path: Path, open_viewer: OpenViewer
) -> None:
    """In the dialect of 2004 each press is one byte, sent on change, and the release is a stop.

    So is the last byte of a server that is ended while somebody drives.
    """
    port = tmp_path / "robot-line"
    with serial_line(port) as line:
        async with serve(tmp_path, toml.card_on(port, "bytes")) as server:
            viewer = await open_viewer(server, drives=True)
            for key, octet in (("s", b"B"), ("ArrowLeft", b"L"), ("d", b"R"), ("ArrowUp", b"F")):
                await hold(server, viewer, key, ends_with(octet, line))
                if octet != b"F":
                    await viewer.page.keyboard.up(key)
                    await eventually(
                        ends_with(b"S", line), "a stop comes down the line", within_s=2
                    )
            await server.stop(signal.SIGTERM)
            await eventually(ends_with(b"S", line), "a stop is the last byte on the line")


@pytest.mark.timeout(120)
async def test_a_key_becomes_frames_that_expire_and_wait_for_a_new_press(
    serve: Serve, tmp_path: Path, board: Board, open_viewer: OpenViewer
) -> None:
    """While it is held frames of this turn come steadily; after its release, a loose wire and a
    pulled plug there are stops, and motion only by a new press.
    """

    async def drives() -> bool:
        return board.moves

    async def rests_since(since_s: float) -> None:
        """See that the server greets the board anew, and then asks for nothing but stops."""
        await until(lambda: "hello" in taken(board, since_s), "the server greets the board anew")
        await asyncio.sleep(0.8)
        assert taken(board, since_s) == {"hello", "stop"}, "it moved without a new press"

    def stopped_itself(since_s: float) -> list[float]:
        return [event["t_s"] for event in board.events(since_s) if event["event"] == "ttl"]

    async with serve(tmp_path, toml.card_on(board.path, "frames")) as server:
        viewer = await open_viewer(server, drives=True)
        turn = (await server.status())["turn"]["number"]
        keys = viewer.page.keyboard

        seen: list[object] = []

        async def steadily() -> bool:
            """Hold a key for a second; tell whether frames came all the time, none a stop."""
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

        assert await undisturbed(server, steadily), f"no frames come steadily: {seen}"
        released_s = time.monotonic()
        await asyncio.sleep(0.3)
        assert taken(board, released_s) - {"hello"} == {"stop"}

        # A line that fails for under half a second stops the robot by its own watchdog.
        await hold(server, viewer, "ArrowUp", drives)
        deaf_s = time.monotonic()
        board.deafen(on=True)
        [stopped_s] = await until(
            lambda: stopped_itself(deaf_s), "the watchdog stops it", within_s=1, every_s=0.005
        )
        board.deafen(on=False)
        await rests_since(stopped_s)
        assert is_connected(await server.status())
        await viewer.page.keyboard.up("ArrowUp")

        # The page reports a lost line, which is opened again while the key is still held.
        await hold(server, viewer, "ArrowUp", drives)
        await board.unplug()
        await the_problem(server)
        told = viewer.page.get_by_text(FOR_GUESTS)
        await told.first.wait_for(state="visible")
        plugged_s = await board.plug()
        await server.until(is_connected, "the line is opened again")
        await told.first.wait_for(state="hidden")
        await rests_since(plugged_s)
        await viewer.page.keyboard.up("ArrowUp")
        await hold(server, viewer, "ArrowUp", drives)
        await viewer.page.keyboard.up("ArrowUp")


def taken(board: Board, since_s: float) -> set[str]:
    frames = [event for event in board.events(since_s) if event["event"] == "frame"]
    return {frame["type"] for frame in frames if frame["verdict"] == "taken"}
