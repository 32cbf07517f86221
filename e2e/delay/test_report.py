"""The report of a run: what it contains, and what it does not hide."""

from __future__ import annotations

from typing import TYPE_CHECKING

from e2e.delay import report
from e2e.delay.cell import Cell
from e2e.delay.imagined_row import measured as row
from e2e.measure.machine import Machine
from e2e.measure.results import Origin, Result, Results

if TYPE_CHECKING:
    from pathlib import Path

MACHINE = Machine(
    cpu="An imagined processor",
    cores=2,
    memory_mib=24_000,
    system="Linux",
    python="3.11",
    versions={"aiortc": "1.16.0"},
    chromium="Chromium 150",
)


def keep(folder: Path, of: Cell, commit: str = "abc", **values: float | None) -> None:
    add(folder, of.variant, commit, rows=[row(of, **values)])


def add(folder: Path, case: str, commit: str, **more: object) -> None:
    result = {
        "case": case,
        "n": 1,
        "origin": Origin(commit=commit, measured=commit, machine=MACHINE),
        "started_utc": "2026-11-22T09:00:00+00:00",
        "took_s": 20.0,
        "load_1min": 0.5,
    }
    Results(folder).add(Result.model_validate(result | more))


def test_a_link_has_its_systems_and_the_thesiss_words(tmp_path: Path) -> None:
    """The results are under their link, next to what the thesis says of it, with its place."""
    thesis = Cell(experiment="units", profile="lan", system="thesis", audio_mu_ms=100)
    keep(tmp_path, thesis, pauses_per_min=30.0, picture_age_p50_ms=612.0)
    keep(tmp_path, Cell(profile="lan", system="stock"), picture_age_p50_ms=None)
    text = "\n".join(report.lines(Results(tmp_path).newest()))
    for part in (
        "\nlan: 100 Mbit/s Ethernet",
        "1–4 per ½ s, up to 800 ms (thesis 5.2.1.2, Figure 5.20)",
        "\n* thesis policy units 100ms (n 1); picture, p50, ms: 612; ",
        "picture, p50, ms: never",
    ):
        assert part in text


def test_the_newest_product_counts_and_what_failed_is_told(tmp_path: Path) -> None:
    """An older product's results are left out; each repetition is listed next to the median."""
    keep(tmp_path, Cell(profile="lan", system="stock"), "old", picture_age_p50_ms=777.0)
    cells = [Cell(profile="lan", system="operator", repeat=repeat) for repeat in range(3)]
    found = [
        row(one, picture_age_p50_ms=ms) for one, ms in zip(cells, (8.0, 9.0, 100.0), strict=True)
    ]
    add(tmp_path, "lan/operator", "new", rows=found)
    add(tmp_path, "lan/livekit", "new", status="failed", problem="No Go here.")
    text = "\n".join(report.lines(Results(tmp_path).newest()))
    assert "777" not in text
    assert ": 9 (8, 9, 100)" in text
    assert "lan/livekit: No Go here." in text
