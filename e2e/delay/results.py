"""One cell with all that was read: what its figures are made of, kept beside the suite's rows."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict

from e2e.delay.cell import Cell
from e2e.delay.figures import Figures
from e2e.delay.readings import Readings


class _Result(BaseModel):
    model_config = ConfigDict(extra="forbid")


class Carried(_Result):
    """What one direction of the link carried during the cell, IP packets."""

    packets: int
    bytes: int
    queue_drops: int
    losses: int


class Server(_Result):
    """The server's process, with its children, while the cell was measured."""

    cpu_share: float
    """Of one core."""
    memory_mib: float


class CellResult(_Result):
    """One cell. `problem` is a sentence where there was no picture in time."""

    cell: Cell
    problem: str | None = None
    figures: Figures
    readings: Readings
    down: Carried
    up: Carried
    server: Server
    browser_cpu_share: float | None = None
    """Of one core: all processes of the browser, where it tells."""
    told: dict[str, float | str] = {}
    """What the system says of itself, as ``viewer.streams.fail_safe_s``."""
