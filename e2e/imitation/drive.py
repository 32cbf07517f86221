"""Drives to the red pillar of the simulated flat, turn after turn, and exports that as a dataset.

`python -m e2e.imitation.drive FOLDER` writes ``FOLDER/dataset``. The driver is a script that sees
only the pictures that everybody sees: it turns until the pillar is ahead, and drives up to it. Its
ways back are turns with another task.
"""

from __future__ import annotations

import asyncio
import random
import sys
import time
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
import tomlkit

from e2e.harness.commands import said_by
from e2e.harness.server import Server
from wax.client import Operator

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from av import VideoFrame

TURNS: Final = 20
TASK: Final = "drive to the red pillar"
_LONGEST_S: Final = 20.0
_LET_GO_S: Final = 0.3
_WIDTH, _HEIGHT = 160, 120
_LEAST_PX: Final = 5
"""Nothing else that is red is as wide up to the top."""
_NEAR: Final = 0.16
"""The pillar is reached when it is this share of the picture's width."""
RECORDING: Final = tomlkit.dumps(
    {"recording": {"enabled": True, "min_free_gb": 0.0, "ask_task": True, "sound": False}}
)


class PillarDriver(Operator):
    """Sees the picture, and drives by it."""

    decodes = True

    @asynccontextmanager
    async def turn_for(self, task: str) -> AsyncIterator[None]:
        """Have a turn with this task."""
        await self.join()
        self.send(type="task", turn=self.turn, text=task)
        self.let_go()  # a turn begins at rest
        await asyncio.sleep(_LET_GO_S)
        yield
        self.let_go()
        await self.leave()

    async def to_the_pillar(self) -> bool:
        """Drive to the pillar; return whether it was reached in time."""
        end_s = time.monotonic() + _LONGEST_S
        while time.monotonic() < end_s:
            _, picture = await self.media.picture()
            await self._obey_the_gate()
            at, width = pillar(picture)
            if width >= _NEAR:
                return True
            ahead = 0.0 if width == 0.0 else max(0.0, 0.8 - 1.6 * abs(at))
            self.steer(ahead, 0.4 if width == 0.0 else -1.2 * at)
        return False

    async def back(self, chance: random.Random) -> None:
        """Drive back and turn away, to begin elsewhere."""
        for linear, angular, seconds in (
            (-0.7, chance.uniform(-0.3, 0.3), chance.uniform(1.5, 4.0)),
            (0.0, chance.choice([-0.5, 0.5]), chance.uniform(0.2, 1.2)),
        ):
            await self._obey_the_gate()
            self.steer(linear, angular)
            await asyncio.sleep(seconds)

    async def _obey_the_gate(self) -> None:
        """Let go where the gate holds the robot: it goes on with those who press again."""
        status = self.newest("drive_status")
        if status.get("reason") and not status["moving"]:
            self.let_go()
            await asyncio.sleep(_LET_GO_S)


def pillar(picture: VideoFrame) -> tuple[float, float]:
    """Return where the pillar is, from -0.5 (left) to 0.5, and how wide, as shares of the width.

    It is the one thing with red stripes up to the top.
    """
    rgb = picture.to_ndarray(format="rgb24", width=_WIDTH, height=_HEIGHT).astype(int)
    red, green, blue = rgb[: _HEIGHT // 2].transpose(2, 0, 1)
    is_red = (red > 1.8 * green) & (red > 1.8 * blue) & (red > 60)
    columns = np.flatnonzero(is_red.mean(axis=0) > 0.3)
    widest = max(np.split(columns, np.flatnonzero(np.diff(columns) > 2) + 1), key=len)
    if len(widest) < _LEAST_PX:
        return 0.0, 0.0
    return float(widest.mean()) / _WIDTH - 0.5, len(widest) / _WIDTH


async def record(folder: Path) -> None:
    """Drive `TURNS` turns, and export them."""
    chance = random.Random(63)
    reached = 0
    async with Server(folder, RECORDING) as server, PillarDriver(server.url, sees=True) as driver:
        for number in range(1, TURNS + 1):
            async with driver.turn_for(TASK):
                is_there = await driver.to_the_pillar()
            reached += is_there
            print(f"turn {number}: {'reached' if is_there else 'not reached'}", flush=True)
            async with driver.turn_for("drive back"):
                await driver.back(chance)
    print(f"reached {reached} of {TURNS}", flush=True)
    asked = ("tape", "export", "--lerobot", str(folder / "dataset"), "--fps", "10")
    print(await said_by(folder, *asked, **server.environment))


if __name__ == "__main__":
    into = Path(sys.argv[1])
    into.mkdir(parents=True)
    asyncio.run(record(into))
