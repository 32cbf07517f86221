"""The host's button: the robot is lent to the proof and comes back, whatever becomes of that."""

from __future__ import annotations

import asyncio
import signal
import sys
from contextlib import suppress
from typing import TYPE_CHECKING, cast

import pytest

from wax import proving as proving_module
from wax.control.latch import StopLatch
from wax.errors import ForbiddenError
from wax.proving import LENT, STOPPED, Proving

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from wax.control.loop import ControlLoop
    from wax.robot.driver import Driver


class Robot:
    """The loop and the driver in one: notes what it is told."""

    def __init__(self) -> None:
        self.told: list[object] = []
        self.latched: StopLatch | None = None

    def maintain(self, reason: str | None) -> None:
        self.told.append(reason)

    def open(self) -> None:
        self.told.append("open")

    def close(self) -> None:
        self.told.append("close")


@pytest.fixture
def robot() -> Robot:
    return Robot()


@pytest.fixture
async def proving(robot: Robot, tmp_path: Path) -> AsyncIterator[Proving]:
    config = tmp_path / "wax.toml"
    config.write_text('[robot]\ndriver = "simulated"\n')
    made = Proving(
        control=cast("ControlLoop", robot),
        driver=cast("Driver", robot),
        config_path=config,
        changed=lambda: None,
    )
    yield made
    await made.stop()


async def _ended(proving: Proving) -> dict[str, object]:
    async with asyncio.timeout(20):
        while proving.progress()["state"] == "running":  # noqa: ASYNC110  # as the page asks
            await asyncio.sleep(0.05)
    return proving.progress()


async def test_the_robot_is_let_go_of_and_taken_back(proving: Proving, robot: Robot) -> None:
    """Nobody drives meanwhile; where nothing can be proved the host reads why, and may go on."""
    assert proving.progress() == {"state": "never", "line": "", "record": None}
    await proving.start()
    with pytest.raises(ForbiddenError, match="already"):
        await proving.start()
    told = await _ended(proving)
    assert told["state"] == "failed"
    assert "simulated" in str(told["line"])
    assert told["record"] is None
    assert robot.told == [LENT, "close", "open", None]
    with pytest.raises(ForbiddenError, match="no record"):
        proving.record()


async def test_a_server_that_ends_keeps_the_robot_shut(proving: Proving, robot: Robot) -> None:
    """The proof ends with the server, and the robot is not opened again."""
    await proving.start()
    await asyncio.sleep(0.1)
    await proving.stop()
    await proving.stop()
    assert robot.told[:2] == [LENT, "close"]
    assert "open" not in robot.told
    with pytest.raises(ForbiddenError, match="ends"):
        await proving.start()


async def test_a_proof_that_does_not_listen_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    """One that ignores the request to end does not live on, whoever waits for it or does not."""
    monkeypatch.setattr(proving_module, "_END_S", 0.2)
    deaf = (
        "import signal, time; signal.signal(signal.SIGTERM, signal.SIG_IGN); print(1, flush=True)"
    )
    for patience_s in (5.0, 0.05):
        process = await asyncio.create_subprocess_exec(
            sys.executable, "-c", f"{deaf}; time.sleep(60)", stdout=asyncio.subprocess.PIPE
        )
        assert process.stdout is not None
        await process.stdout.readline()
        with suppress(TimeoutError):
            async with asyncio.timeout(patience_s):
                await proving_module._end(process)
        assert await asyncio.wait_for(process.wait(), 5) == -signal.SIGKILL


async def test_a_stop_breaks_the_proof_off(proving: Proving, robot: Robot) -> None:
    """Whoever presses Stop stops the robot of the proof too, and none begins while that lasts."""
    await proving.start()
    robot.latched = StopLatch(1, "Ada")
    told = await _ended(proving)
    assert (told["state"], told["line"]) == ("failed", STOPPED)
    with pytest.raises(ForbiddenError, match="release it first"):
        await proving.start()
    robot.latched = None
    await proving.start()
