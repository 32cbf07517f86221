"""The servers that are compared, each in a process of its own."""

from __future__ import annotations

import asyncio
import sys
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final

import tomlkit
from tests.free_port import free_port

from e2e.harness import toml
from e2e.harness.board import Board
from e2e.harness.child import child
from e2e.harness.server import Server
from e2e.load.crowd.sample import Offering
from e2e.load.process import ProcessMeter, pinned
from e2e.measure.errors import MeasureError
from e2e.measure.suite import ROOT
from e2e.peers import janus

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

WAX: Final = "WAX"
STOCK: Final = "stock aiortc"
JANUS: Final = "Janus"
SIDES: Final = (WAX, STOCK)

SETTINGS: Final[dict[str, Any]] = {
    **toml.MEDIA,
    # Turns last as long as the run; departed viewers are forgotten soon, so that waits are short.
    "turns": {"turn_s": 3600.0, "grace_s": 0.5},
}


class MeasuredServer(Server):
    """One server, kept on `core` if one is given."""

    def __init__(self, side: str, folder: Path, settings: dict[str, Any], core: int | None) -> None:
        super().__init__(folder, tomlkit.dumps(SETTINGS | settings))
        self.side = side
        self._core = core

    async def launch(self) -> None:
        with pinned(self._core):
            if self.side == WAX:
                await super().launch()
                return
            with self.log_path.open("ab") as log:
                self._process = await asyncio.create_subprocess_exec(
                    *(sys.executable, "-m", "e2e.peers.stock", "127.0.0.1", str(self.port)),
                    cwd=ROOT,
                    stdout=log,
                    stderr=log,
                )

    @property
    def meter(self) -> ProcessMeter:
        return ProcessMeter(self.pid)

    @property
    def offering(self) -> Offering:
        return Offering(url=self.url, how="wax" if self.side == WAX else "stock")


@dataclass(frozen=True, slots=True)
class JanusServer:
    """Janus, kept on a core; the programs that feed it are not counted."""

    meter: ProcessMeter
    offering: Offering


@asynccontextmanager
async def serving(
    side: str, core: int | None = None, **settings: Any
) -> AsyncIterator[MeasuredServer]:
    """Serve inside the block; raises `MeasureError` if it does not start."""
    with TemporaryDirectory(prefix="wax-load-") as folder:
        server = MeasuredServer(side, Path(folder), settings, core)
        try:
            try:
                await server.start()
            except AssertionError as error:
                log = server.log.strip().splitlines() or ["no log"]
                raise MeasureError(f"{side} does not serve; its log ends: {log[-1]}") from error
            yield server
        finally:
            await server.kill()


@asynccontextmanager
async def serving_board(
    core: int | None = None, **settings: Any
) -> AsyncIterator[tuple[MeasuredServer, Board]]:
    """Serve WAX with the board of our firmware; raises `MeasureError`."""
    with TemporaryDirectory(prefix="wax-load-") as folder:
        async with (
            Board(Path(folder)) as board,
            serving(WAX, core, robot=board.robot, **settings) as server,
        ):
            yield server, board


@asynccontextmanager
async def serving_janus(core: int, feeders_core: int) -> AsyncIterator[JanusServer]:
    """Serve by Janus; raises `NotRunError` if it is missing."""
    port = free_port()
    with TemporaryDirectory(prefix="janus-") as folder, pinned(core):
        async with janus.running(Path(folder), port) as process:
            with pinned(feeders_core):
                async with child("e2e.peers.janus_feed", port + 1, port + 2):
                    offering = Offering(url=f"http://127.0.0.1:{port}/janus", how="janus")
                    yield JanusServer(ProcessMeter(process.pid), offering)
