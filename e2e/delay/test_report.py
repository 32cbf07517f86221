"""The page of a run: what is in it, and what it does not hide."""

from __future__ import annotations

from typing import TYPE_CHECKING

from e2e.delay import report
from e2e.delay.cell import Cell
from e2e.measure.machine import Machine
from e2e.measure.results import Origin, Result, Results
from e2e.measure.row import Row

if TYPE_CHECKING:
    from pathlib import Path

MACHINE = Machine(
    cpu="An imagined <processor>",
    cores=2,
    memory_mib=24_000,
    system="Linux",
    python="3.11",
    versions={"aiortc": "1.16.0"},
    chromium="Chromium 150",
)


def keep(folder: Path, of: Cell, commit: str = "abc", **values: float | None) -> None:
    row = Row(key=of.key, what="", n=1, values=values, detail={"cell": of.model_dump()})
    add(folder, of.variant, commit, rows=[row])


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


def test_there_is_no_page_of_nothing(tmp_path: Path) -> None:
    """Without results nothing is written."""
    assert report.write(tmp_path) is None


def test_a_link_has_its_systems_and_the_thesiss_words(tmp_path: Path) -> None:
    """What was found stands under its link, beside what the thesis says of that with its place."""
    thesis = Cell(experiment="units", profile="lan", system="thesis", audio_mu_ms=100)
    keep(tmp_path, thesis, pauses_per_min=30.0, picture_age_p50_ms=612.0)
    keep(tmp_path, Cell(profile="lan", system="stock"), picture_age_p50_ms=None)
    path = report.write(tmp_path)
    assert path is not None
    page = path.read_text(encoding="utf-8")
    for part in ("<h2>lan</h2>", "1–4 per ½ s", "thesis 5.2.1.2, Figure 5.20", ">612<", ">never<"):
        assert part in page
    assert "<th>thesis policy units 100ms</th>" in page
    assert "<script" not in page


def test_the_newest_product_counts_and_text_is_escaped(tmp_path: Path) -> None:
    """An older product's results are left out, a failure is told, no text becomes markup."""
    keep(tmp_path, Cell(profile="lan", system="stock"), "old", picture_age_p50_ms=777.0)
    keep(tmp_path, Cell(profile="lan", system="operator"), "new", picture_age_p50_ms=8.0)
    add(tmp_path, "lan/livekit", "new", status="failed", problem="No <Go> here.")
    page = report.html(Results(tmp_path).newest())
    assert ">777<" not in page
    assert ">8<" in page
    assert "lan/livekit: No &lt;Go&gt; here." in page
    assert "An imagined &lt;processor&gt;" in page
