"""A program that watches what operators see and do, from a picture to its set-point."""

from __future__ import annotations

import asyncio
import re
import sys
from pathlib import Path

import numpy as np
import pytest
import tomlkit
from e2e.harness import toml
from e2e.harness.server import Server
from tests.capture.card_reader import read_stamp

from wax.capture.testcard import STAMP_MODULUS
from wax.client import Follower, Operator

MANUAL = Path(__file__).parents[2] / "config/README.md"
SMALL = tomlkit.dumps(toml.merged(toml.MEDIA, {"video": {"width": 160, "height": 120}}))


async def drives(operator: Operator, follower: Follower) -> None:
    """Drive ahead, from rest, as a turn begins."""
    await operator.join()
    rest = {"turn": operator.turn, "linear_mps": 0.0, "reason": None}
    assert await follower.until(lambda: rest.items() <= follower.newest("driven").items())
    operator.steer(0.5)


@pytest.mark.system
@pytest.mark.timeout(60)
async def test_a_program_sees_what_somebody_drives_by(tmp_path: Path) -> None:
    """Each picture comes with its capture, and with what somebody makes the robot do; the manual's
    program prints both.
    """
    [code] = re.findall(r"```python\n(import asyncio\n.*?)```", MANUAL.read_text(), re.DOTALL)
    async with (
        Server(tmp_path, SMALL) as server,
        Operator(server.url, sees=True) as operator,
        Follower(server.url) as follower,
    ):
        program = await asyncio.create_subprocess_exec(
            *(sys.executable, "-u", "-c", code.replace("http://127.0.0.1:8080", server.url)),
            stdout=asyncio.subprocess.PIPE,
        )
        assert program.stdout is not None
        try:
            await drives(operator, follower)
            errors_ms = []
            async for seen in follower.watch():
                shown = read_stamp(np.asarray(seen.picture.to_ndarray(format="yuv420p"), np.uint8))
                if shown is not None:
                    errors_ms.append((shown - round(seen.captured_ms)) % STAMP_MODULUS)
                if seen.driven["linear_mps"] > 0 and len(errors_ms) >= 20:
                    break
            # The server's clock counts from another moment than the card's.
            assert max(errors_ms) - min(errors_ms) <= 2
            async for line in program.stdout:
                if re.search(rb"\(\d+, \d+, 3\).*'linear_mps': 0\.[1-9]", line):
                    break
        finally:
            program.kill()
            await program.wait()
