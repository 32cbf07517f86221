"""A dataset from end to end: driven on a board, recorded, exported, and compared with its log."""

from __future__ import annotations

import asyncio
import random
from bisect import bisect_right
from typing import TYPE_CHECKING, Any, Final

import av
import numpy as np
import pyarrow.parquet as pq
import pytest
from tests.capture.card_reader import read_stamp

from e2e.harness import toml
from e2e.harness.commands import said_by
from wax.capture.testcard import STAMP_MODULUS
from wax.client import Operator
from wax.clock import UNIX_ZERO_S
from wax.config.settings import Settings
from wax.driver.interface import Twist
from wax.robot.wheels import WheelMixer

if TYPE_CHECKING:
    from pathlib import Path

    from e2e.conftest import Serve
    from e2e.harness.board import Board

STEPS: Final = 8
STEP_S: Final = 0.5
LET_GO_S: Final = 0.3
UNDER_WAY: Final = 2
"""So many set-points at most have been sent, but have not arrived."""
ROUNDED_MMPS: Final = 0.501
"""A frame for the board has whole mm/s, the dataset 32-bit numbers."""
RECORDING: Final = "enabled = true\nmin_free_gb = 0.0\nsound = false"


def obeyed(board: Board) -> tuple[list[float], list[tuple[int, int]]]:
    """Return when the board got set-points, in seconds since 1970, and both wheels' mm/s."""
    frames = [
        one
        for one in board.events()
        if one["event"] == "frame" and one["verdict"] == "taken" and one["type"] != "hello"
    ]
    wheels = [(one.get("left", 0), one.get("right", 0)) for one in frames]
    return [one["t_s"] + UNIX_ZERO_S for one in frames], wheels


def stamps_ms(folder: Path) -> list[int]:
    """Return the time on each picture, in ms modulo that of the test card."""
    (video,) = (folder / "videos").rglob("*.mp4")
    with av.open(str(video)) as media:
        found = [
            read_stamp(one.to_ndarray(format="gray").astype(np.uint8))
            for one in media.decode(video=0)
        ]
    assert None not in found
    return [one for one in found if one is not None]


@pytest.mark.full
@pytest.mark.timeout(120)
async def test_each_frame_is_what_was_seen_and_what_the_board_was_told(
    serve: Serve, tmp_path: Path, board: Board
) -> None:
    """Each picture shows its row's time, and each action is what the board obeyed then."""
    chance = random.Random(9)
    robot = {"robot": f'driver = "serial"\nserial = {{ url = "{board.path}" }}'}
    async with serve(tmp_path, toml.card_with(**robot, recording=RECORDING)) as server:
        async with Operator(server.url, sees=True) as operator:
            await operator.join()
            for _ in range(STEPS):
                operator.let_go()  # as a turn begins, and as one who was late goes on
                await asyncio.sleep(LET_GO_S)
                operator.steer(chance.uniform(-1, 1), chance.uniform(-1, 1))
                await asyncio.sleep(STEP_S)
            operator.let_go()
            await operator.leave()
        environment = server.environment
    out = tmp_path / "dataset"
    await said_by(tmp_path, "tape", "export", "--lerobot", str(out), **environment)
    (path,) = (out / "data").rglob("*.parquet")
    rows: list[dict[str, Any]] = pq.read_table(path).to_pylist()

    half_a_frame_ms = 500 * (rows[1]["timestamp"] - rows[0]["timestamp"])
    for row, stamp_ms in zip(rows, stamps_ms(out), strict=True):
        late_ms = (row["wax.captured_s"] * 1000 - stamp_ms + 1000) % STAMP_MODULUS - 1000
        assert abs(late_ms) <= half_a_frame_ms

    mixer = WheelMixer(Settings().robot)
    times_s, wheels = obeyed(board)
    for row in rows:
        speeds = mixer.mix(Twist(*row["action"]))
        sent = tuple(speeds[side] * 1000 for side in ("left", "right"))
        newest = bisect_right(times_s, row["wax.captured_s"])
        told = wheels[newest - 1 : newest + UNDER_WAY]
        assert any(one == pytest.approx(sent, abs=ROUNDED_MMPS) for one in told), row
    assert len({tuple(row["action"]) for row in rows}) > STEPS
