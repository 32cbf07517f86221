"""The host's button "Prove the stop": the robot is lent to `wax prove-stop` and taken back.

The proof is a separate program, because it cuts off the server: it starts its own server on the
robot that this one has released.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Final

import structlog

from wax import folders
from wax.errors import ForbiddenError
from wax.protocol.http_bodies import ProofProgress, ProofState
from wax.sentence import Sentence, read, says

if TYPE_CHECKING:
    from wax.session.parts import Parts

_LOG = structlog.get_logger(__name__)

LENT: Final = Sentence("robot.lent")
STOPPED: Final = Sentence("proof.stopped")
_POLL_S: Final = 0.02
_END_S: Final = 5.0
"""How long the proof may take to stop the robot; a server that is shutting down waits less."""

NOT_ALL: Final = 3
"""The proof's exit status if every stop was in time, but not everything could be cut."""


class ProofRunner:
    """One proof at a time; the driver is closed for it and opened again."""

    def __init__(self, parts: Parts, config_path: Path | None) -> None:
        self._control = parts.control
        self._driver = parts.driver
        self._viewers = parts.viewers
        self._config_path = config_path
        self._state: ProofState = "never"
        self._line: Sentence | None = None
        self._record: str | None = None
        self._task: asyncio.Task[None] | None = None
        self._process: asyncio.subprocess.Process | None = None
        self._is_ending = False
        self._is_asked = False  # whether the process was told to end

    def progress(self) -> ProofProgress:
        """Return the progress, and the path of the newest record."""
        record = None if self._record is None else "api/proof/record"
        return ProofProgress(state=self._state, line=self._line, record=record)

    def record(self) -> str:
        """Return the newest record as HTML; raises `ForbiddenError` if there is none."""
        if self._record is None:
            raise ForbiddenError(Sentence("proof.no_record"))
        return self._record

    async def start(self) -> None:
        """Take the robot from everybody and start; raises `ForbiddenError` if impossible."""
        if self._is_ending:
            raise ForbiddenError(Sentence("proof.too_late"))
        if self._state == "running":
            raise ForbiddenError(Sentence("proof.runs"))
        if self._control.latched is not None:
            raise ForbiddenError(Sentence("proof.release_first"))
        self._state, self._line = "running", Sentence("proof.released")
        self._task = asyncio.create_task(self._lend(), name="prove-stop")

    def break_off(self) -> None:
        """Stop the robot of a running proof, at once and for good; safe to call twice."""
        self._is_ending = True
        if self._process is not None and self._process.returncode is None and not self._is_asked:
            self._is_asked = True
            self._process.terminate()

    async def stop(self) -> None:
        """End a running proof for good, with the robot stopped. Safe to call twice."""
        self.break_off()
        task, self._task = self._task, None
        if task is not None:
            task.cancel()
            await asyncio.gather(task, return_exceptions=True)

    async def _lend(self) -> None:
        self._control.lend_driver(LENT)
        self._viewers.changed()
        try:
            await asyncio.to_thread(self._driver.close)
            await self._prove()
        except Exception as error:
            _LOG.exception("the proof could not be run")
            self._state, self._line = "failed", Sentence("proof.not_run", {"why": str(error)})
        finally:
            if self._state == "running":
                self._state, self._line = "failed", Sentence("proof.aborted")
            if not self._is_ending:
                self._driver.open()
                self._control.lend_driver(None)
                self._viewers.changed()

    async def _prove(self) -> None:
        with folders.temporary("wax-proof-") as folder:
            record = Path(folder) / "record.html"
            process = await asyncio.create_subprocess_exec(
                *self._command(record),
                stdin=asyncio.subprocess.PIPE,  # closes when this server is gone
                stdout=asyncio.subprocess.PIPE,
                stderr=asyncio.subprocess.PIPE,
            )
            self._process, self._is_asked = process, False
            stopping = asyncio.create_task(self._obey_stop(process))
            try:
                said, complaint = await self._follow(process)
                code = await process.wait()
            finally:
                stopping.cancel()
                await self._end(process)
            self._record = record.read_text(encoding="utf-8") if record.is_file() else None
        if self._control.latched is not None:
            self._state, self._line = "failed", STOPPED
        elif self._record is None:
            self._state, self._line = "failed", complaint or Sentence("proof.no_result")
        else:
            self._state, self._line = "done" if code in (0, NOT_ALL) else "failed", said

    async def _obey_stop(self, process: asyncio.subprocess.Process) -> None:
        """Abort the proof, which stops the robot, when anybody presses Stop."""
        while self._control.latched is None:  # noqa: ASYNC110  # the latch has no event
            await asyncio.sleep(_POLL_S)
        await self._end(process)

    async def _end(self, process: asyncio.subprocess.Process) -> None:
        is_asked, self._is_asked = self._is_asked, True
        await _end(process, is_asked=is_asked)

    def _command(self, record: Path) -> list[str]:
        config = [] if self._config_path is None else ["--config", str(self._config_path)]
        command = [sys.executable, "-m", "wax", *config, "prove-stop", "--lifted", "--json"]
        return [*command, "--record", str(record)]

    async def _follow(
        self, process: asyncio.subprocess.Process
    ) -> tuple[Sentence | None, Sentence | None]:
        """Show the proof's progress; return its last line, and the last line of its errors."""
        assert process.stdout is not None
        assert process.stderr is not None
        complaints = asyncio.create_task(process.stderr.read())
        said: Sentence | None = None
        async for line in process.stdout:
            with contextlib.suppress(ValueError, KeyError, TypeError):
                told = json.loads(line)
                said = read(told["sentence"])
                done, of = int(told["done"]), int(told["of"])
                self._line = Sentence("proof.step", {"step": said, "done": done, "of": of})
        complaint = (await complaints).decode(errors="replace").strip()
        return said, says(complaint.rpartition("\n")[2]) if complaint else None


async def _end(process: asyncio.subprocess.Process, *, is_asked: bool = False) -> None:
    """Ask the proof to stop its robot and end; kill it if it does not in time.

    `terminate` is called only once: it polls the process, and may so take the exit code that
    asyncio's watcher waits for.
    """
    if process.returncode is not None:
        return
    if not is_asked:
        process.terminate()
    try:
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(process.wait(), _END_S)
    finally:
        if process.returncode is None:
            process.kill()
