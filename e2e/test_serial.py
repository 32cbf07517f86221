"""From a key in the browser to bytes on a real pseudo-terminal."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest
import pytest_asyncio

from e2e.harness import toml
from e2e.harness.line import SerialLine
from e2e.harness.wait import eventually
from wax.robot.serial.frames import Decoder, Drive, Hello, Stop

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from e2e.conftest import OpenViewer, Serve
    from e2e.harness.server import Server
    from e2e.harness.viewer import Viewer
    from wax.robot.serial.frames import Frame


@pytest_asyncio.fixture(loop_scope="session")
async def line(tmp_path: Path) -> AsyncIterator[SerialLine]:
    cable = SerialLine(tmp_path)
    cable.plug()
    yield cable
    cable.unplug()


def settings(line: SerialLine, dialect: str) -> str:
    return toml.card_with(
        robot='driver = "serial"',
        robot__serial=f'url = "{line.path}"\ndialect = "{dialect}"\nreopen_s = 0.2',
    )


def frames(line: SerialLine) -> list[Frame]:
    """Decode everything received since `forget`; raises `AssertionError` on a damaged frame."""
    decoder = Decoder()
    found = decoder.feed(bytes(line.received))
    assert decoder.errors == 0, f"{decoder.errors} damaged frames"
    return found


def moves(line: SerialLine, dialect: str) -> bool:
    """Tell whether anything received since `forget` would move the robot."""
    if dialect == "bytes":
        return any(octet in b"FBLRGIHJ" for octet in line.received)
    drives = [frame.body for frame in frames(line) if isinstance(frame.body, Drive)]
    return any(drive.left_mmps or drive.right_mmps for drive in drives)


async def take_the_wheel(open_viewer: OpenViewer, server: Server) -> Viewer:
    viewer = await open_viewer(server)
    await viewer.join()
    await viewer.drives()
    return viewer


async def receives(line: SerialLine, octet: bytes, within_s: float = 2) -> None:
    async def so() -> bool:
        return octet in line.received

    await eventually(so, f"{octet!r} comes down the line", within_s=within_s, every_s=0.02)


@pytest.mark.timeout(90)
async def test_a_key_becomes_one_byte_and_its_release_another(
    serve: Serve, tmp_path: Path, line: SerialLine, open_viewer: OpenViewer
) -> None:
    """In the dialect of 2004 each press is one byte, sent on change, and the release is a stop."""
    async with serve(tmp_path, settings(line, "bytes")) as server:
        viewer = await take_the_wheel(open_viewer, server)
        for key, octet in (("ArrowUp", b"F"), ("s", b"B"), ("ArrowLeft", b"L"), ("d", b"R")):
            await asyncio.sleep(0.3)
            line.forget()
            await viewer.page.keyboard.down(key)
            await receives(line, octet)
            assert b"S" not in line.received[line.received.index(octet) :]
            line.forget()
            await viewer.page.keyboard.up(key)
            await receives(line, b"S")


@pytest.mark.timeout(90)
async def test_a_key_becomes_frames_that_expire(
    serve: Serve, tmp_path: Path, line: SerialLine, open_viewer: OpenViewer
) -> None:
    """While a key is held whole frames of this turn come steadily; its release brings a stop."""
    async with serve(tmp_path, settings(line, "frames")) as server:
        viewer = await take_the_wheel(open_viewer, server)
        turn = (await server.status())["turn"]["number"]
        assert isinstance(frames(line)[0].body, Hello)
        await asyncio.sleep(0.2)
        line.forget()
        await viewer.page.keyboard.down("ArrowUp")
        await asyncio.sleep(1)
        held = frames(line)
        line.forget()
        await viewer.page.keyboard.up("ArrowUp")
        await asyncio.sleep(0.5)
        released = frames(line)

        drives = [frame for frame in held if isinstance(frame.body, Drive)]
        assert len(drives) >= 20, f"only {len(drives)} frames in a second"
        assert {frame.turn for frame in drives} == {turn}
        assert all(20 <= frame.ttl_ms <= 1000 for frame in drives)
        sequence = [frame.sequence for frame in held]
        assert sequence == sorted(set(sequence)), "sequence numbers do not rise"
        last = drives[-1].body
        assert isinstance(last, Drive)
        assert last.left_mmps > 0
        assert last.left_mmps == last.right_mmps

        stands = [
            isinstance(frame.body, Stop) or frame.body == Drive(0, 0) for frame in released[-10:]
        ]
        assert stands, "nothing was sent after the release"
        assert all(stands)


@pytest.mark.timeout(90)
@pytest.mark.parametrize("dialect", ["frames", "bytes"])
async def test_a_pulled_plug_is_told_and_nothing_moves_until_a_new_press(
    serve: Serve, tmp_path: Path, line: SerialLine, open_viewer: OpenViewer, dialect: str
) -> None:
    """Without the line the page says so; it comes back by itself, but motion needs a new press."""
    async with serve(tmp_path, settings(line, dialect)) as server:
        viewer = await take_the_wheel(open_viewer, server)

        async def drives() -> bool:
            return moves(line, dialect)

        await viewer.page.keyboard.down("ArrowUp")
        await eventually(drives, "the robot is told to move", within_s=2)
        line.unplug()

        async def problem() -> str:
            return str((await server.status())["robot"]["problem"] or "")

        sentence = await eventually(problem, "the server knows of the loss", within_s=3)
        await viewer.page.get_by_text(sentence).first.wait_for(state="visible", timeout=2000)

        line.forget()
        line.plug()

        async def mended() -> bool:
            return bool((await server.status())["robot"]["connected"])

        await eventually(mended, "the line is opened again", within_s=5)
        await viewer.page.get_by_text(sentence).first.wait_for(state="hidden", timeout=2000)
        await asyncio.sleep(1)
        assert line.received, "nothing is said on the new line"
        assert not moves(line, dialect), "it moved without a new press"
        await viewer.page.keyboard.up("ArrowUp")
        await asyncio.sleep(0.2)
        await viewer.page.keyboard.down("ArrowUp")
        await eventually(drives, "the robot is told to move again", within_s=2)
        await viewer.page.keyboard.up("ArrowUp")


@pytest.mark.timeout(90)
async def test_a_missing_port_does_not_keep_the_server_from_starting(
    serve: Serve, tmp_path: Path, line: SerialLine, open_viewer: OpenViewer
) -> None:
    """With no robot plugged in the picture plays and the page says what is missing."""
    line.unplug()
    async with serve(tmp_path, settings(line, "frames")) as server:
        viewer = await open_viewer(server)
        robot = (await server.status())["robot"]
        assert robot["connected"] is False
        await viewer.page.get_by_text(robot["problem"]).first.wait_for(timeout=3000)
        line.plug()

        async def found() -> bool:
            return bool((await server.status())["robot"]["connected"])

        await eventually(found, "the robot is found when it is plugged in", within_s=5)
