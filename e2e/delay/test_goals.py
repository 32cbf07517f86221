"""The goals: enough is measured, often enough, within the half hour; and how it is judged."""

from __future__ import annotations

import os
from collections import Counter
from typing import TYPE_CHECKING, Any

import pytest

from e2e.delay import goals
from e2e.delay.cell import Cell
from e2e.delay.measures import MEASURES
from e2e.delay.plan import estimate_s
from e2e.delay.systems.settings import DRIVES_HZ, settings
from e2e.measure.row import Row

if TYPE_CHECKING:
    from e2e.delay.cell import SystemName


def cell(system: SystemName, repeat: int = 0, **more: Any) -> Cell:
    return Cell(experiment="G", profile="same-machine", system=system, repeat=repeat, **more)


def measured(of: Cell, **values: float | None) -> Row:
    return Row(key=of.key, what="", n=1, values=values, detail={"cell": of.model_dump()})


def judged(rows: list[Row], measure: str, kind: str = "cells") -> Row:
    key = f"same-machine/operator/{measure}/{kind}"
    return next(row for row in goals.derive(rows) if row.key == key)


def test_it_is_about_half_an_hour() -> None:
    """Three repetitions with the peers end within 40 minutes; only --long takes longer."""
    assert estimate_s(goals.planned()) <= 40 * 60
    assert max(one.seconds for one in goals.planned()) == goals.STEADY_S
    assert max(one.seconds for one in goals.planned(long=True)) == 600


def test_what_is_judged_is_measured_three_times() -> None:
    """Ours, and whom a goal compares with, in every repetition; other peers once."""
    times = Counter(one.variant for one in goals.planned())
    assert set(times.values()) == {1, goals.REPEATS}
    once = {variant for variant, number in times.items() if number == 1}
    assert all("/stock" in variant or "/livekit" in variant for variant in once)
    assert times["G/same-machine/livekit/20s"] == 3
    keys = [one.key for one in goals.planned()]
    assert len(keys) == len(set(keys))


@pytest.mark.parametrize("cores", [2, 8])
def test_every_promise_has_its_cells(monkeypatch: pytest.MonkeyPatch, cores: int) -> None:
    """A run of the plan leaves no goal unjudged, on a small machine or a large one."""
    monkeypatch.setattr(os, "cpu_count", lambda: cores)
    values = dict.fromkeys(MEASURES, 1.0)
    rows = [measured(one, **values) for one in goals.planned(repeats=1)]
    found = goals.derive(rows)
    assert len(found) >= 20
    assert all(row.met is not None for row in found)
    crowd = next(row for row in found if row.key.endswith("/crowd"))
    assert crowd.load.startswith("100 observers" if cores == 8 else "40 observers")


def test_who_drives_sends_as_often_as_promised() -> None:
    """The cell that drives sets the rate of the set-points, others leave it as shipped."""
    driving = Cell(experiment="G", profile="modem-56k", system="operator", drives=True)
    assert settings(driving, "testcard")["drive"] == {"command_rate_hz": DRIVES_HZ}
    assert "drive" not in settings(driving.model_copy(update={"drives": False}), "testcard")


def test_the_median_is_judged_and_the_better_peer() -> None:
    """A goal relative to the peers is missed where the better one is too near, not the worse."""
    name = "picture_age_p50_ms"
    ours = [measured(cell("operator", n), **{name: ms}) for n, ms in enumerate((10.0, 12, 90))]
    slow, quick = measured(cell("stock"), **{name: 80.0}), measured(cell("livekit"), **{name: 20.0})
    assert judged([*ours, slow], name).met is True
    assert judged([*ours, slow, quick], name).met is False
    assert judged(ours, name).met is None
    found = judged([*ours, slow], name)
    assert (found.n, found.goal, found.values["WAX"]) == (3, 20, 12)


def test_a_cell_without_a_picture_is_a_miss() -> None:
    """Where no picture came nothing was reached; a link with no cell of ours has no row."""
    assert judged([measured(cell("operator"))], "picture_age_p95_ms").met is False
    assert goals.derive([measured(cell("stock"), picture_age_p95_ms=10.0)]) == []


def test_an_instrument_that_reads_wrong_is_told_first() -> None:
    """What is known of the lab's own errors stands before the goals, and can be missed too."""
    wrong = Row(key="instrument/picture", what="", n=1, values={"off": 9.0}, goal=5.0, met=False)
    rows = [wrong, measured(cell("operator"), picture_age_p95_ms=10.0)]
    assert goals.derive(rows)[0] == wrong


def test_a_further_observer_costs_the_difference() -> None:
    """Of each repetition by itself: what the larger crowd takes more, for each of its viewers."""
    crowds = [
        measured(cell("operator", n, viewers=viewers), server_cpu=30 + 10.0 * n + more)
        for n in range(3)
        for viewers, more in ((11, 0.0), (41, 6.0))
    ]
    stock = [
        measured(cell("stock", viewers=viewers), server_cpu=cpu)
        for viewers, cpu in ((2, 30.0), (4, 50.0))
    ]
    found = judged([*crowds, *stock], "server_cpu", "cost")
    assert found.values["WAX"] == pytest.approx(0.2)
    assert found.values["stock aiortc"] == pytest.approx(10)
    assert found.met is True


def test_a_crowd_is_held_against_being_alone() -> None:
    """The operator's picture with the largest crowd less that of the same repetition alone."""
    rows = [
        measured(cell("operator", viewers=viewers), picture_age_p95_ms=ms)
        for viewers, ms in ((1, 12.0), (11, 14.0), (41, 20.0))
    ]
    found = judged(rows, "picture_age_p95_ms", "crowd")
    assert (found.values["WAX"], found.met) == (8.0, False)


def test_never_is_worse_than_any_time() -> None:
    """A step after which the picture stays old is a miss that says so, not a missing number."""
    step = Cell(experiment="G", profile="step-down", system="operator", seconds=32.0)
    rows = [
        measured(step.model_copy(update={"repeat": n}), fresh_after_ms=ms)
        for n, ms in enumerate((None, None, 900.0))
    ]
    (found,) = [row for row in goals.derive(rows) if "/fresh_after_ms/" in row.key]
    assert (found.values["WAX"], found.met) == (None, False)
