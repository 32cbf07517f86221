"""The core behind a pseudo-terminal, as `wax-board`: a board that can be unplugged."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any

import pytest
import pytest_asyncio
from e2e.harness.board import Board
from e2e.harness.wait import eventually

from wax.clock import SystemClock
from wax.config.robot import RobotSettings
from wax.driver.interface import STANDSTILL, Twist
from wax.robot.serial.driver import SerialRobot

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator
    from pathlib import Path

pytestmark = pytest.mark.system

AHEAD = Twist(0.5, 0.0)


@pytest_asyncio.fixture
async def board(tmp_path: Path) -> AsyncIterator[Board]:
    board = Board(tmp_path)
    await board.start()
    yield board
    await board.stop()
    assert not board.path.is_symlink()


@pytest.fixture
def robot(board: Board) -> Iterator[SerialRobot]:
    serial = {"url": str(board.path), "reopen_s": 0.05}
    settings = RobotSettings.model_validate({"driver": "serial", "serial": serial})
    robot = SerialRobot(settings, SystemClock())
    robot.open()
    yield robot
    robot.close()


async def connected(robot: SerialRobot) -> None:
    async def so() -> bool:
        return robot.state().connected

    await eventually(so, "the board answers", every_s=0.005)


async def drive(robot: SerialRobot, board: Board) -> None:
    """Stand, then drive ahead until the board's wheels turn."""
    await connected(robot)
    robot.apply(STANDSTILL, 1)

    async def moves() -> bool:
        robot.apply(AHEAD, 1)
        return board.moves

    await eventually(moves, "the wheels turn", every_s=0.01)


def of(board: Board, event: str, since_s: float = 0.0) -> list[dict[str, Any]]:
    return [one for one in board.events(since_s) if one["event"] == event]


async def test_it_drives_and_tells(board: Board, robot: SerialRobot) -> None:
    """The server's commands move the wheels, and the board's knowledge comes back."""
    await drive(robot, board)
    board.charge(6900)
    board.press(4)

    async def told() -> bool:
        robot.apply(AHEAD, 1)
        state = robot.state()
        known = state.extra
        return (
            state.moving is True
            and (state.battery_v, state.bumpers) == (6.9, 4)
            and known["left_ticks"] > 100
        )

    await eventually(told, "the report tells so", every_s=0.01)
    drives = [frame for frame in of(board, "frame") if frame["type"] == "drive"]
    assert {(frame["verdict"], frame["turn"], frame["left"]) for frame in drives} == {
        ("taken", 1, 500)
    }


@pytest.mark.alone
async def test_it_stops_by_itself_when_the_cable_is_pulled(
    board: Board, robot: SerialRobot
) -> None:
    """It stands within 250 ms of its last frame, stays alive, and stands when plugged in."""
    await drive(robot, board)

    async def drives_on() -> None:
        """Drive on; otherwise it would be told to stand before the cable is out."""
        while True:
            robot.apply(AHEAD, 1)
            await asyncio.sleep(0.01)

    driving = asyncio.create_task(drives_on())
    out_s = await board.unplug()
    driving.cancel()

    async def stands() -> bool:
        return not board.moves

    await eventually(stands, "the wheels stand", every_s=0.01)
    last_s = [frame["t_s"] for frame in of(board, "frame") if frame["type"] == "drive"][-1]
    stood_s = of(board, "wheels", out_s)[-1]["t_s"]
    assert stood_s - last_s <= 0.25
    assert len(of(board, "ttl", out_s)) == 1
    back_s = await board.plug()
    await connected(robot)
    for _ in range(20):
        robot.apply(AHEAD, 1)
        await asyncio.sleep(0.01)
    assert not of(board, "wheels", back_s)
    assert not of(board, "start", back_s)


@pytest.mark.parametrize(
    ("base", "wheels"),
    [
        ("mecanum", {"left": 0, "right": 800, "back_left": 800, "back_right": 0}),
        ("omni", {"left": 146, "right": 546, "back": 400}),
    ],
)
async def test_a_base_that_moves_sideways_is_driven_so(
    tmp_path: Path, base: str, wheels: dict[str, int]
) -> None:
    """At a diagonal's full speed its log has each wheel and each part of the motion."""
    async with Board(tmp_path, base=base) as board:
        serial = board.robot | {"max_linear_mps": 0.566}
        robot = SerialRobot(RobotSettings.model_validate(serial), SystemClock())
        robot.open()
        try:
            await connected(robot)
            robot.apply(STANDSTILL, 1)

            async def goes() -> bool:
                robot.apply(Twist(0.4, 0.0, 0.4), 1)
                turned = of(board, "wheels")
                return bool(turned) and turned[-1].items() >= wheels.items()

            await eventually(goes, "all wheels turn as fast as they should", every_s=0.01)
            moves = [frame for frame in of(board, "frame") if frame["type"] == "move"]
            parts = {(one["verdict"], one["linear"], one["lateral"]) for one in moves}
            assert parts == {("taken", 400, 400)}
            robot.stop(1)

            async def stands() -> bool:
                return not board.moves

            await eventually(stands, "the wheels stand", every_s=0.01)
            assert set(of(board, "wheels")[-1]) - {"t_s", "event"} == set(wheels)
        finally:
            robot.close()


async def test_a_restart_forgets_the_session(board: Board, robot: SerialRobot) -> None:
    """After a restart the old session's frames count as damage, and the wheels stand."""
    await drive(robot, board)
    reset_s = await board.reset()
    robot.apply(AHEAD, 1)

    async def damaged() -> bool:
        return bool(of(board, "damaged", reset_s))

    await eventually(damaged, "a frame of the old session comes", every_s=0.01)
    assert not board.moves
    assert not [frame for frame in of(board, "frame", reset_s) if frame["type"] == "drive"]


@pytest.mark.parametrize("wire", ["mute", "deafen"])
async def test_a_loose_wire_is_no_answer(board: Board, robot: SerialRobot, wire: str) -> None:
    """A loose wire, either one, is reported as a robot that does not answer, until it is fixed."""
    await connected(robot)
    getattr(board, wire)(on=True)

    async def told() -> bool:
        return "does not answer" in str(robot.state().problem)

    await eventually(told, "the server knows", every_s=0.005)
    getattr(board, wire)(on=False)
    await connected(robot)


async def test_a_board_that_starts_slowly_is_waited_for(tmp_path: Path) -> None:
    """A board in its boot loader neither receives nor sends; once it is up it is found."""
    board = Board(tmp_path, boot_ms=800)
    await board.start()
    serial = {"url": str(board.path), "reopen_s": 0.05}
    settings = RobotSettings.model_validate({"driver": "serial", "serial": serial})
    robot = SerialRobot(settings, SystemClock())
    robot.open()
    try:
        await connected(robot)
        assert of(board, "frame")[0]["t_s"] - of(board, "start")[0]["t_s"] >= 0.8
    finally:
        robot.close()
        await board.stop()
