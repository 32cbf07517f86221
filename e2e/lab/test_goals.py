"""What the goals are judged by: enough of it, often enough, and within the half hour."""

from __future__ import annotations

import os
from collections import Counter

import pytest

from e2e.lab import goals
from e2e.lab.cell import Cell
from e2e.lab.plan import estimate_s
from e2e.lab.report import synthetic
from e2e.lab.report.goals import goals as promised
from e2e.lab.report.goals import judge, observers
from e2e.lab.report.pick import entries
from e2e.lab.systems.settings import DRIVES_HZ, settings
from e2e.lab.wanted import Wanted


def test_it_is_about_half_an_hour() -> None:
    """Three repetitions with the peers end within 40 minutes; only --long takes longer."""
    assert estimate_s(goals.planned(), own_error=True) <= 40 * 60
    assert max(cell.seconds for cell in goals.planned()) == goals.STEADY_S
    assert max(cell.seconds for cell in goals.planned(long=True)) == 600


def test_what_is_judged_is_measured_three_times() -> None:
    """Ours, and whom a goal compares with, in every repetition; other peers once."""
    times = Counter(cell.variant for cell in goals.planned())
    assert set(times.values()) == {1, goals.REPEATS}
    once = {variant for variant, number in times.items() if number == 1}
    assert all("/stock" in variant or "/livekit" in variant for variant in once)
    assert times["G/same-machine/livekit/20s"] == times["G/internet-5m/stock/20s"] == 3
    keys = [cell.key for cell in goals.planned()]
    assert len(keys) == len(set(keys))


@pytest.mark.parametrize("cores", [2, 8])
def test_every_promise_has_its_cells(monkeypatch: pytest.MonkeyPatch, cores: int) -> None:
    """A run of the plan leaves no goal unjudged, on a small machine or a large one."""
    monkeypatch.setattr(os, "cpu_count", lambda: cores)
    cells = goals.planned(repeats=1)
    run = entries(synthetic.run([synthetic.measured(cell) for cell in cells]))
    found = list(promised(run))
    assert len(found) >= 26
    for goal in found:
        assert judge(goal, run).cells[goal.system], goal
    assert observers(run, "operator")[-1] == (100 if cores == 8 else 40)


def test_a_part_is_measured_alone() -> None:
    """Patterns choose among the goals' cells as among the others, each repetition alike."""
    cells = Wanted(goals=True, repeats=3, only=["modem-56k/operator"]).cells()
    assert [cell.key for cell in cells] == [
        f"G/modem-56k/operator/drives/60s/{repeat}" for repeat in range(3)
    ]
    assert not Wanted(goals=True).is_trimmed


def test_who_drives_sends_as_often_as_promised() -> None:
    """The cell that drives sets the rate of the set-points, others leave it as shipped."""
    cell = Cell(experiment="G", profile="modem-56k", system="operator", drives=True)
    assert settings(cell, "testcard")["drive"] == {"command_rate_hz": DRIVES_HZ}
    assert "drive" not in settings(cell.model_copy(update={"drives": False}), "testcard")
