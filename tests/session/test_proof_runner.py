"""The host's button: the robot is lent to the proof and taken back, whatever the result."""

from __future__ import annotations

import asyncio
import signal
import sys
from contextlib import suppress
from html import unescape
from types import SimpleNamespace
from typing import TYPE_CHECKING, cast

import pytest
from tests.examples import at_length

from wax.commands.proof.verdict import FAULTS
from wax.control.stop_latch import LatchedStop
from wax.errors import ForbiddenError
from wax.protocol.http_bodies import ProofProgress
from wax.sentence import says
from wax.session import proof_runner as proving_module
from wax.session.proof_runner import LENT, STOPPED, ProofRunner

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from collections.abc import AsyncIterator
    from pathlib import Path

    from wax.session.parts import Parts

pytestmark = pytest.mark.system


PAPER = "tests.session.paper_proof"


class Robot:
    """The loop and the driver in one: notes what it is told."""

    def __init__(self) -> None:
        self.told: list[object] = []
        self.latched: LatchedStop | None = None

    def lend_driver(self, reason: str | None) -> None:
        self.told.append(reason)

    def open(self) -> None:
        self.told.append("open")

    def close(self) -> None:
        self.told.append("close")


@pytest.fixture
def robot() -> Robot:
    return Robot()


@pytest.fixture
async def proving(robot: Robot, tmp_path: Path) -> AsyncIterator[ProofRunner]:
    config = tmp_path / "wax.toml"
    config.write_text('[robot]\ndriver = "simulated"\n')
    viewers = SimpleNamespace(changed=lambda: None)
    parts = SimpleNamespace(control=robot, driver=robot, viewers=viewers)
    made = ProofRunner(cast("Parts", parts), config)
    yield made
    await made.stop()


async def _ended(proving: ProofRunner) -> ProofProgress:
    async with asyncio.timeout(50):  # a busy machine takes half of it to start a program
        while proving.progress().state == "running":  # noqa: ASYNC110  # as the page asks
            await asyncio.sleep(0.05)
    return proving.progress()


async def test_the_robot_is_released_and_taken_back(proving: ProofRunner, robot: Robot) -> None:
    """Nobody drives meanwhile; if nothing can be proved, the host reads why and can go on."""
    assert proving.progress() == ProofProgress(state="never", line=None, record=None)
    await proving.start()
    with pytest.raises(ForbiddenError, match="already"):
        await proving.start()
    told = await _ended(proving)
    assert told.state == "failed"
    assert "simulated" in str(told.line)
    assert told.record is None
    assert robot.told == [LENT, "close", "open", None]
    with pytest.raises(ForbiddenError, match="no record"):
        proving.record()


CUT = "Every link was cut 5 times; the robot stood within 200 ms"
LATE = "; ".join(str(fault.title) for fault in FAULTS)
PROOFS = {
    "in time": ("", "done", f"{CUT}, its own braking included."),
    "in part": (
        'robot.serial.dialect = "bytes"',
        "done",
        "Each measurable link was cut 5 times; the robot was told to stop within"
        " 150 ms. Not proved: The driver process is killed;"
        " The serial line is cut.",
    ),
    "too late": (
        "drive = { max_age_ms = 1000, max_command_age_ms = 2000 }",
        "failed",
        f"Not proved: too late, or no stop at all: {LATE}.",
    ),
}


@pytest.mark.parametrize(
    ("config", "state", "sentence"),
    [*at_length(PROOFS["in time"]), PROOFS["in part"], PROOFS["too late"]],
    ids=PROOFS,
)
async def test_the_page_claims_no_more_than_the_record(
    proving: ProofRunner,
    robot: Robot,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    *,
    config: str,
    state: str,
    sentence: str,
) -> None:
    """The last line is the record's own sentence, whatever could be measured; the robot is back."""
    (tmp_path / "wax.toml").write_text(f'robot.driver = "serial"\n{config}\n')
    wax = proving._command
    monkeypatch.setattr(
        proving, "_command", lambda record: [sys.executable, "-m", PAPER, *wax(record)[3:]]
    )
    await proving.start()
    told = await _ended(proving)
    assert (told.state, str(told.line), told.record) == (state, sentence, "api/proof/record")
    assert f">{sentence}</p>" in unescape(proving.record())
    assert robot.told == [LENT, "close", "open", None]


async def _under_way(proving: ProofRunner, monkeypatch: pytest.MonkeyPatch) -> Process:
    """Start a proof that lasts a minute unless somebody ends it."""
    minute = [sys.executable, "-c", "import time; time.sleep(60)"]
    monkeypatch.setattr(proving, "_command", lambda _record: minute)
    await proving.start()
    async with asyncio.timeout(10):
        while proving._process is None:  # noqa: ASYNC110  # it has no event
            await asyncio.sleep(0.01)
    return proving._process


async def test_a_server_that_ends_keeps_the_robot_closed(
    proving: ProofRunner, robot: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The proof ends with the server, and the robot is not opened again."""
    process = await _under_way(proving, monkeypatch)
    await proving.stop()
    assert process.returncode == -signal.SIGTERM
    await proving.stop()
    assert robot.told[:2] == [LENT, "close"]
    assert "open" not in robot.told
    with pytest.raises(ForbiddenError, match="shutting down"):
        await proving.start()


async def test_a_proof_that_ignores_terminate_is_killed(monkeypatch: pytest.MonkeyPatch) -> None:
    """A proof that ignores `terminate` does not live on, whether or not somebody waits for it."""
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


async def test_a_stop_breaks_the_proof_off(
    proving: ProofRunner, robot: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Stop also stops a proof's robot, and no proof begins while the stop is in force."""
    process = await _under_way(proving, monkeypatch)
    robot.latched = LatchedStop(1, says("Ada"))
    assert await asyncio.wait_for(process.wait(), 5) == -signal.SIGTERM
    told = await _ended(proving)
    assert (told.state, told.line) == ("failed", STOPPED)
    with pytest.raises(ForbiddenError, match="release the stop first"):
        await proving.start()
    robot.latched = None
    await proving.start()
