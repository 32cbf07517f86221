"""How goals are judged, and that a run judges all of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

from e2e.delay import suite
from e2e.delay.cell import Cell
from e2e.delay.imagined_row import measured
from e2e.delay.judging import COLUMNS, goals, judged
from e2e.delay.measures import MEASURES
from e2e.delay.plan import DRIVES, planned
from e2e.delay.systems.settings import settings
from e2e.measure.errors import MeasureError
from e2e.measure.row import Row, summed
from e2e.measure.row import judged as beside

if TYPE_CHECKING:
    from pathlib import Path

    from e2e.delay.names import SystemName

P50 = "picture_age_p50_ms"


def cell(system: SystemName, repeat: int = 0, **more: Any) -> Cell:
    return Cell.model_validate(
        {"profile": "same-machine", "system": system, "repeat": repeat} | more
    )


def row(rows: list[Row], measure: str, where: str = "same-machine", kind: str = "cells") -> Row:
    (found,) = [one for one in judged(rows) if one.key == f"{where}/operator/{measure}/{kind}"]
    return found


def test_every_goal_has_its_cells(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A run of the plan judges every goal, a recorded drive's too; the published cells theirs."""
    for name in ("town.down", "town.up"):
        (tmp_path / name).write_text("1\n5\n")
    monkeypatch.setenv(DRIVES, str(tmp_path))
    plan = planned()
    values = dict.fromkeys(MEASURES, 1.0)
    everything = judged([measured(one.cell, **values) for one in plan])
    assert {one.key for one in everything} == {
        goal.key for goal in goals([str(tmp_path / "town.down")])
    }
    assert all(one.met is not None for one in everything)
    published = judged([measured(one.cell, **values) for one in plan if not one.long])
    assert len(published) == sum(goal.experiment == "G" for goal in goals())


def test_the_plan_is_published_in_its_time() -> None:
    """No cell comes twice, ours have three runs, and the published ones take about 55 minutes."""
    variants = [one.cell.variant for one in planned()]
    assert len(variants) == len(set(variants))
    assert {one.cell.experiment for one in planned() if not one.long} == {"G"}
    assert sum(case.minutes for case in suite.SUITE.cases if not case.long) <= 58
    keys = [case.key for case in suite.SUITE.cases]
    assert len(keys) == len(set(keys))


def test_a_folder_without_drives_is_one_sentence(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Whoever asks for recorded drives is told if there are none."""
    monkeypatch.setenv(DRIVES, str(tmp_path))
    with pytest.raises(MeasureError, match=r"no file ends in \.down"):
        planned()


def test_who_drives_the_modem_sends_as_often_as_promised() -> None:
    """The goals of the modem are driven at 20 set-points a second, by WAX alone."""
    driven = [one.cell for one in planned() if one.cell.drives and not one.long]
    assert {one.profile for one in driven} == {"modem-56k"}
    assert all(settings(one)["drive"]["command_rate_hz"] == 20 for one in driven)


def test_the_median_is_judged_and_the_better_peer_counts() -> None:
    """One outlier does not decide; of the peers that a goal names, the better one counts."""
    ours = [measured(cell("operator", n), **{P50: ms}) for n, ms in enumerate((10.0, 12, 90))]
    slow, quick = (
        measured(cell("stock"), **{P50: 80.0}),
        measured(cell("livekit-whip"), **{P50: 20}),
    )
    assert row([*ours, slow], P50).met is True
    assert row([*ours, slow, quick], P50).met is False
    assert row(ours, P50).met is None
    found = row([*ours, slow], P50)
    assert (found.n, found.goal, found.values["WAX"]) == (3, 20, 12)
    assert set(found.values) == set(COLUMNS)


def test_sharpness_is_held_against_the_sharpest() -> None:
    """Of what is to be great, the greatest of the peers' medians is the least that counts."""
    peers = [
        measured(cell("stock"), sharpness_ssim=0.6),
        measured(cell("livekit"), sharpness_ssim=0.8),
    ]
    for ours, met in ((0.8, True), (0.7, False)):
        found = row([measured(cell("operator"), sharpness_ssim=ours), *peers], "sharpness_ssim")
        assert (found.goal, found.at_least, found.met) == (0.8, True, met)
    assert found.what.endswith("sharpness, SSIM (≥ the best peer’s)")


def test_who_plays_has_a_column() -> None:
    """The browser's player has a column next to ours, and the thesis's policy next to both."""
    rows = [
        measured(cell("operator"), browser_cpu=40.0),
        measured(cell("operator", player="browser"), browser_cpu=30.0),
        measured(cell("thesis"), browser_cpu=20.0),
    ]
    found = row(rows, "browser_cpu")
    assert (found.goal, found.met) == (35.0, False)
    assert found.values["browser’s player"] == 30
    assert found.values["thesis policy"] == 20


def test_a_cell_without_a_picture_is_a_miss() -> None:
    """Without a picture nothing was reached; a link with no cell of ours has no row."""
    assert row([measured(cell("operator"))], "picture_age_p95_ms").met is False
    assert judged([measured(cell("stock"), picture_age_p95_ms=10.0)]) == []


def test_never_is_worse_than_any_time() -> None:
    """A step after which the picture stays old is a miss that says so, not a missing number."""
    rows = [
        measured(cell("operator", n, profile="step-down"), fresh_after_ms=ms)
        for n, ms in enumerate((None, None, 900.0))
    ]
    found = row(rows, "fresh_after_ms", "step-down")
    assert (found.values["WAX"], found.met) == (None, False)


def test_a_crowd_is_held_against_being_alone() -> None:
    """The operator's picture age with the crowd, less that of the same operator alone."""
    rows = [
        measured(cell("operator", viewers=viewers), picture_age_p95_ms=ms)
        for viewers, ms in ((1, 12.0), (41, 20.0))
    ]
    found = row(rows, "picture_age_p95_ms", kind="crowd")
    assert (found.values["WAX"], found.met) == (8.0, False)


def test_the_size_of_a_drift_is_judged() -> None:
    """Falling behind and running ahead by as much count the same."""
    of = cell("operator", profile="modem-56k", experiment="steady")
    rows = judged([measured(of, picture_drift_ms_per_min=-30.0)])
    assert [(one.values["WAX"], one.met) for one in rows if "picture_drift" in one.key] == [
        (30.0, False)
    ]


def test_what_is_timed_stands_in_the_columns() -> None:
    """WAX's judged quantile is next to the peers'; the worse of press and release counts."""
    press = summed("input/key", "a key", "ms", [1.0, 2.0], 20, judged="p99")
    release = summed("input/key: release", "… let go", "ms", [1.0, 30.0], 20, judged="p99")
    first = summed("first-picture/x", "a link", "ms", [700.0], 1000, judged="p95")
    stock = beside(
        "first-picture/x: stock", "…", "ms", {"median": 1.0, "p95": 9.0}, n=1, column="median"
    )
    wrong = Row(key="instrument/picture", what="", n=1, values={"off": 9.0}, goal=5.0, met=False)
    own, key, opened = suite.derive([press, release, first, stock, wrong])
    assert own == wrong
    assert (key.values, key.met, key.judged) == ({"WAX": 30.0}, False, "WAX")
    assert opened.values == {"WAX": 700.0, "stock aiortc": 9.0}
    assert opened.what == "a link, p95"
