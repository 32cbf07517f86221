"""Runs that nobody measured, for tests: what `Run` allows, with raw series that fit its figures."""

from __future__ import annotations

import math
from random import Random
from statistics import median
from typing import TYPE_CHECKING, Any, Final

from e2e.lab.figures import Figures, Kinds, Pauses, Quantiles
from e2e.lab.readings import Commands, Counters, Pictures, Readings, Sound
from e2e.lab.results import CellResult, Run, Server, Way

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.lab.cell import Cell

START_MS: Final = 1_790_000_000_000.0
MACHINE: Final[dict[str, Any]] = {
    "cpu": "An imagined processor",
    "cores": 2,
    "memory_mib": 24_000,
    "versions": {"aiortc": "1.16.0", "av": "18.1.0"},
    "commit": "c316766",
    "real_time_priority": False,
}


def run(cells: Sequence[CellResult], **changed: Any) -> Run:
    """Make a run of these cells."""
    given: dict[str, Any] = {
        "started_utc": "2026-11-20T09:30:00+00:00",
        "took_s": 3421.5,
        "arguments": ["--repeat", "1"],
        "machine": MACHINE,
        "cells": list(cells),
        "instrument": {"two_instruments_ms": 1.2, "shift_read_ms": 100.8},
    }
    return Run(**(given | changed))


def failed(cell: Cell, problem: str | None, status: str = "failed") -> CellResult:
    """Make a cell that has nothing but a sentence."""
    return CellResult.model_validate(
        {
            "cell": cell,
            "status": status,
            "problem": problem,
            "started_utc": "2026-11-20T09:31:00+00:00",
            "took_s": 0.4,
        }
    )


def measured(
    cell: Cell,
    *,
    picture_ms: float = 60.0,
    sound_ms: float = 80.0,
    fps: float = 30.0,
    pauses: Sequence[tuple[float, float]] = (),
    cpu_share: float = 0.2,
    grows_from_s: float | None = None,
    grows_until_s: float | None = None,
    limits: Sequence[str] = (),
    told: dict[str, float | str] | None = None,
) -> CellResult:
    """Make a cell that is ok: `pauses` are (s, ms) after the measuring began.

    Between `grows_from_s` and `grows_until_s` no picture comes and the sound is late by a second.
    """
    chance = Random(cell.key)
    from_ms, to_ms = START_MS + 3000.0, START_MS + 3000.0 + 1000.0 * cell.seconds

    def is_bad(at_ms: float) -> bool:
        if grows_from_s is None or grows_until_s is None:
            return False
        return grows_from_s <= (at_ms - from_ms) / 1000 < grows_until_s

    shown = [START_MS + 1000.0 * number / fps for number in range(int(fps * (cell.seconds + 3)))]
    shown = [at_ms for at_ms in shown if not is_bad(at_ms)]
    ages = [picture_ms + chance.expovariate(1 / (0.1 * picture_ms + 1)) for _ in shown]
    rows = [START_MS + 10.0 * number for number in range(int(100 * (cell.seconds + 3)))]
    gaps = [(from_ms + 1000 * at_s, length_ms) for at_s, length_ms in pauses]
    speaks = cell.content == "face"
    readings = Readings(
        opened_ms=START_MS - 900.0,
        first_picture_ms=START_MS - 100.0,
        first_sound_ms=START_MS,
        pictures=Pictures(
            at_ms=shown,
            stamp_ms=[at - age for at, age in zip(shown, ages, strict=True)],
            mouth=[0.5 if speaks else None for _ in shown],
            width=[640 for _ in shown],
        ),
        sound=Sound(
            start_ms=rows,
            rms=[0.05 for _ in rows],
            tone=[
                0.0
                if speaks or any(at <= row < at + length for at, length in gaps)
                else 0.05 + chance.gauss(0, 0.001)
                for row in rows
            ],
            burst=[0.0 if speaks else _burst(row, sound_ms + 1000 * is_bad(row)) for row in rows],
        ),
        counters=_counters([from_ms, to_ms]),
        commands=Commands(at_ms=[from_ms], round_trip_ms=[21.0]),
        limits=list(limits),
    )
    listed = Pauses(at_ms=[at for at, _ in gaps], length_ms=[length for _, length in gaps])
    skew_ms = sound_ms - median(ages)
    return CellResult(
        cell=cell,
        status="ok",
        started_utc="2026-11-20T09:31:00+00:00",
        took_s=cell.seconds + 8,
        figures=Figures(
            from_ms=from_ms,
            to_ms=to_ms,
            picture_age_ms=_quantiles(ages),
            sound_age_ms=None if speaks else _quantiles([sound_ms] * 12),
            skew_ms=None if speaks else _quantiles([skew_ms] * 12),
            absolute_skew_p95_ms=None if speaks else abs(skew_ms),
            pictures_per_s=fps,
            longest_freeze_ms=1500 / fps,
            tone_pauses=listed,
            concealed_pauses=Pauses(at_ms=listed.at_ms[::2], length_ms=listed.length_ms[::2]),
            concealed_share=sum(listed.length_ms) / (1000 * cell.seconds),
            first_picture_ms=800.0 + 10 * picture_ms,
            command_round_trip_ms=_quantiles([20.0, 22.0, 41.0]),
            received_bytes_per_s=Kinds(audio=8000, video=fps * 3000, data=120, other=300),
            sent_bytes_per_s=Kinds(data=900, other=200),
            picture_drift_ms_per_min=-0.4,
            lip_lag_ms=skew_ms if speaks else None,
            lip_correlation=0.83 if speaks else None,
        ),
        readings=readings,
        down=Way(packets=1200, bytes=900_000, queue_drops=3, losses=1),
        up=Way(packets=700, bytes=80_000, queue_drops=0, losses=0),
        server=Server(cpu_share=cpu_share, memory_mib=180.0),
        told=told or {},
    )


def bare(cell: Cell) -> CellResult:
    """Make a cell that is ok and in which nothing could be measured."""
    return CellResult(
        cell=cell,
        status="ok",
        started_utc="",
        took_s=math.inf,
        figures=Figures(from_ms=0.0, to_ms=0.0),
        readings=Readings(opened_ms=0.0),
    )


def _counters(at_ms: list[float]) -> Counters:
    """Make looks of a browser that counts nothing."""
    columns: dict[str, list[float | None]] = {
        name: [None for _ in at_ms] for name in Counters.model_fields if name != "at_ms"
    }
    return Counters(at_ms=at_ms, **columns)


def _burst(row_ms: float, age_ms: float) -> float:
    """Give the amplitude in 10 ms of a burst of 100 ms that was captured at a whole second."""
    begins = (row_ms - age_ms) % 1000.0
    if begins < 100.0:
        return 0.4 * min(1.0, (100.0 - begins) / 10.0)
    return 0.4 * (begins - 990.0) / 10.0 if begins > 990.0 else 0.0


def _quantiles(values: Sequence[float]) -> Quantiles | None:
    if not values:
        return None
    ordered = sorted(values)
    rank = max(0, math.ceil(0.95 * len(ordered)) - 1)
    return Quantiles(
        n=len(ordered),
        min=ordered[0],
        p50=median(ordered),
        p95=ordered[rank],
        max=ordered[-1],
    )
