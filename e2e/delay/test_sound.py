"""The plan of the sound's goals, and what is judged beside whom."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Any

import pytest

from e2e.delay import sound
from e2e.delay.__main__ import main
from e2e.delay.cell import Cell
from e2e.delay.measures import MEASURES
from e2e.measure.row import Row

if TYPE_CHECKING:
    from pathlib import Path

    from e2e.delay.cell import SystemName

DRIVES = ("/traces/town.down",)


def row_of(cell: Cell, values: dict[str, float]) -> Row:
    return Row(key=cell.key, what="", n=1, values={**values}, detail={"cell": cell.model_dump()})


def measured(profile: str, system: SystemName, values: dict[str, float], **more: Any) -> Row:
    return row_of(Cell(experiment="G", profile=profile, system=system, **more), values)


def all_measured(cells: list[Cell]) -> list[Row]:
    return [row_of(cell, dict.fromkeys(MEASURES, 1.0)) for cell in cells]


def judged(rows: list[Row], key: str) -> Row:
    return next(row for row in sound.derive(rows) if row.key == f"{key}/cells")


def test_every_goal_has_its_cells_and_whom_it_compares_with_as_often() -> None:
    """A run of the plan leaves no goal unjudged; what none compares with is measured once."""
    cells = sound.planned(drives=DRIVES)
    found = sound.derive(all_measured(cells))
    assert len(found) == len(list(sound.goals(DRIVES)))
    assert all(row.met is not None for row in found)
    assert {row.n for row in found} == {1, sound.REPEATS}
    assert all(row.n == 1 for row in found if "speech" in row.key)
    times = Counter(cell.variant for cell in cells)
    assert times["G/town/stock/60s"] == 0
    assert times["G//traces/town.down/stock/60s"] == sound.REPEATS
    assert len({cell.key for cell in cells}) == len(cells)


def test_what_is_published_names_no_folder() -> None:
    """Recorded drives lie where somebody has them; a row has their name alone."""
    rows = all_measured(sound.planned(drives=DRIVES, repeats=1))
    found = [row for row in sound.derive(rows) if row.key.startswith("town/")]
    assert found
    assert not any("traces" in row.key + row.what for row in found)


def test_each_player_has_a_column_of_its_own() -> None:
    """The goal is about the page as it is shipped, beside the browser's player."""
    p50 = "sound_age_p50_ms"
    ours = measured("modem-56k", "operator", {p50: 280.0})
    beside = measured("modem-56k", "operator", {p50: 360.0}, player="browser")
    row = judged([ours, beside], f"modem-56k/operator/{p50}")
    assert (row.values["WAX"], row.values["browser’s player"]) == (280.0, 360.0)
    assert row.goal == pytest.approx(288)
    assert row.met is True
    assert "≤ 0.8 × browser’s player’s" in row.what


def test_drift_is_judged_by_the_half_hour_and_nothing_else_is() -> None:
    """A minute is too short for a drift of 5 ms, and half an hour is not a row's repetition."""
    p50 = "sound_age_p50_ms"
    short = measured("same-machine", "audio-master", {p50: 60.0, sound.DRIFT: 3.0}, seconds=60.0)
    hour = {p50: 70.0, sound.DRIFT: -0.2}
    long = measured("same-machine", "audio-master", hour, seconds=sound.LONG_SECONDS)
    drift = judged([short, long], f"same-machine/audio-master/{sound.DRIFT}")
    assert (drift.values["WAX"], drift.met, drift.load) == (0.2, False, "1800 s")
    age = judged([short, long], f"same-machine/audio-master/{p50}")
    assert (age.values["WAX"], age.met, age.load) == (60.0, True, "60 s")


def test_more_speech_quality_is_better_and_more_cpu_is_not() -> None:
    """A score below the browser's player is missed; so is a page that costs 6 % of a core more."""
    name = "speech_quality"
    rows = [
        measured("cafe", "audio-master", {name: score}, player=player, content="talking-head")
        for player, score in (("auto", 4.1), ("browser", 4.2))
    ]
    found = judged(rows, f"cafe/audio-master/{name}")
    assert (found.at_least, found.goal, found.met) == (True, 4.2, False)
    rows = [
        measured("same-machine", "operator", {"browser_cpu": percent}, player=player)
        for player, percent in (("auto", 36.0), ("browser", 30.0))
    ]
    found = judged(rows, "same-machine/operator/browser_cpu")
    assert (found.goal, found.met) == (35.0, False)


def test_drives_are_asked_for_by_their_folder(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A folder without a recorded drive is told in a sentence, with one its cells are listed."""
    assert main(["--sound", "--drives", str(tmp_path), "--list"]) == 2
    assert "no file ends in .down" in capsys.readouterr().err
    for way in ("down", "up"):
        (tmp_path / f"town.{way}").write_text("1\n5\n")
    assert main(["--sound", "--drives", str(tmp_path), "--list"]) == 0
    assert f"{tmp_path}/town.down/operator" in capsys.readouterr().out
