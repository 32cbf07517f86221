"""What a run of the lab leaves behind: one JSON with every figure and every raw series."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict

from e2e.lab.cell import Cell
from e2e.lab.figures import Figures
from e2e.lab.readings import Readings


class _Result(BaseModel):
    model_config = ConfigDict(extra="forbid")


class Way(_Result):
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
    """One cell. A failure is a cell that says so: `problem` is one sentence."""

    cell: Cell
    status: Literal["ok", "failed", "not run"]
    problem: str | None = None
    started_utc: str
    took_s: float
    figures: Figures | None = None
    readings: Readings | None = None
    down: Way | None = None
    up: Way | None = None
    server: Server | None = None
    told: dict[str, float | str] = {}
    """What the system says of itself, as ``fail_safe_s``."""


class Run(_Result):
    """Everything once, or again and again."""

    started_utc: str
    took_s: float
    arguments: list[str]
    machine: dict[str, Any]
    """As `e2e.measure.machine.describe` tells it, and whether the link has real-time priority."""
    cells: list[CellResult]
    client2004: list[dict[str, Any]] = []
    """The rows of `e2e.lab.client2004`."""
    instrument: dict[str, Any] = {}
    """Its own error, measured in this run."""
    emulator: list[dict[str, Any]] = []
    """Of each profile what the link made of it (`e2e.lab.emulator`), where that was asked for."""
