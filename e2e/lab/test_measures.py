"""The goals: the numbers that they need, the judgement, and the table that a person reads."""

from __future__ import annotations

import math
from typing import Any

import pytest

from e2e.lab.figures import Figures
from e2e.lab.instrument.sums import picture_ages
from e2e.lab.instrument.synthetic import OPENED_MS, counters, readings
from e2e.lab.readings import Connections, Pictures, Readings, SetPoints
from e2e.lab.report import goal_measures, goals, synthetic
from e2e.lab.report.pick import entries
from e2e.lab.report.reader import a_cell, page_of
from e2e.lab.report.sections import goals as section
from e2e.lab.results import CellResult, Server

START = OPENED_MS
DROP = [(5, 30, 50, 640), (6, 30, 400, 640)]


def span(seconds: float) -> Figures:
    return Figures(from_ms=START, to_ms=START + 1000 * seconds)


def shown(*parts: tuple[float, float, float, int]) -> Pictures:
    """Pictures in parts: until when, s; how many a second; their age, ms; their width."""
    found, begin_s = Pictures(), 0.0
    for until_s, rate, age_ms, width in parts:
        for number in range(round((until_s - begin_s) * rate)):
            at_ms = START + 1000 * (begin_s + number / rate)
            found.at_ms.append(at_ms)
            found.stamp_ms.append(at_ms - age_ms)
            found.mouth.append(None)
            found.width.append(width)
            found.height.append(width * 3 // 4)
        begin_s = until_s
    return found


def seen(*parts: tuple[float, float, float, int]) -> Readings:
    return Readings(opened_ms=START, first_picture_ms=START, pictures=shown(*parts))


def test_skew_counts_from_three_seconds_after_joining() -> None:
    """What is out of step in the first 3 s is let be, and all that comes later counts."""
    found = readings(20.0, picture_age_ms=80, sound_age_ms=120)
    assert goal_measures.skew_p95_ms(found, span(20)) == pytest.approx(40, abs=2)
    late = found.model_copy(update={"first_picture_ms": START + 60_000})
    assert goal_measures.skew_p95_ms(late, span(20)) is None


def test_concealment_counts_from_the_first_sound() -> None:
    """Of 2 s after the first sound 100 ms were made up; what was before it does not count."""
    rows = [(100.0, 1)] * 10 + [(0.0, 0)] * 10 + [(100.0, 1)] + [(0.0, 0)] * 10
    found = Readings(opened_ms=START, first_sound_ms=START + 1000, counters=counters(rows))
    assert goal_measures.concealed_share(found, span(60)) == pytest.approx(0.05, abs=0.005)
    silent = found.model_copy(update={"first_sound_ms": None})
    assert goal_measures.concealed_share(silent, span(60)) is None


def test_a_rate_is_of_pictures_of_that_size() -> None:
    """Smaller pictures do not count for the larger size; runs without heights go by width."""
    found = seen((10, 30, 50, 640), (20, 10, 50, 320))
    get = goal_measures.MEASURES["goal_pictures_640_per_s"].get
    cell = synthetic.measured(a_cell()).model_copy(update={"readings": found, "figures": span(20)})
    assert get(cell) == pytest.approx(15, abs=0.1)
    found.pictures.height = []
    assert get(cell) == pytest.approx(15, abs=0.1)


@pytest.mark.parametrize(
    ("parts", "expected_ms"),
    [
        ([(20, 30, 50, 640)], 0),
        ([(5, 30, 50, 640), (6.5, 30, 400, 640), (20, 30, 100, 160)], 1500),
        ([*DROP, (6.5, 30, 90, 640), (7, 30, 500, 64)], None),
        ([*DROP, (6.5, 30, 90, 640), (7, 30, 500, 64), (20, 30, 90, 64)], 2000),
        ([(5, 30, 50, 640), (20, 30, 400, 640)], None),
        # One picture stands, and grows old, until the next comes at 9 s.
        ([(5, 30, 50, 640), (9, 0.001, 0, 640), (20, 30, 50, 640)], 4000),
    ],
)
def test_fresh_again_is_held_for_a_second(
    parts: list[tuple[float, float, float, int]], expected_ms: float | None
) -> None:
    """From the step at 5 s until no picture is, or stands until it is, 300 ms old for a second."""
    ages = picture_ages(shown(*parts))
    found = goal_measures.fresh_after_ms(ages, START + 5000, START + 20_000)
    assert found == (None if expected_ms is None else pytest.approx(expected_ms, abs=40))


def test_full_quality_is_size_and_rate() -> None:
    """It is full again when a whole second has large pictures at the full rate, not before."""
    found = seen((10, 10, 90, 160), (12, 30, 90, 320), (14, 10, 90, 640), (20, 30, 50, 640))
    sized = goal_measures.sized(found, goal_measures.FULL)
    assert goal_measures.full_after_ms(sized, START + 10_000) == pytest.approx(4000, abs=150)
    assert goal_measures.full_after_ms(sized, START + 19_500) is None


def test_a_break_is_seen() -> None:
    """Connected once and all along is 0; each change of it counts, and so does a dead end."""
    found = seen((10, 30, 50, 640))
    states = ["connecting", "connected", "disconnected", "connected"]
    for number, expected in ((2, 0), (4, 2)):
        some = states[:number]
        found.connections = Connections(at_ms=[0.0] * number, peer=[0] * number, state=some)
        assert goal_measures.breaks(found, span(10)) == expected
        assert goal_measures.breaks(found, span(60)) == expected + 1
    found.connections = Connections()
    assert goal_measures.breaks(found, span(10)) is None


def test_driving_is_seen() -> None:
    """The rate of the set-points is of the measured time; none were sent by who only watches."""
    found = seen((1, 30, 50, 640))
    assert goal_measures.set_points_per_s(found, span(10)) is None
    sent = [START + 50 * number for number in range(400)]
    found.set_points = SetPoints(at_ms=sent, buffered_bytes=[0] * 400)
    assert goal_measures.set_points_per_s(found, span(10)) == pytest.approx(20, abs=0.2)


def result(system: str, repeat: int = 0, cpu: float = 0.2, **more: Any) -> CellResult:
    measured = {key: more.pop(key) for key in ("picture_ms", "sound_ms") if key in more}
    cell = a_cell("G", "same-machine", system, repeat=repeat, seconds=20.0, **more)
    made = synthetic.measured(cell, **measured)
    return made.model_copy(update={"server": Server(cpu_share=cpu, memory_mib=100.0)})


def judged(cells: list[CellResult], name: str) -> goals.Judged:
    run = entries(synthetic.run(cells))
    (goal,) = [
        one
        for one in goals.goals(run)
        if one.measure.name == name and (one.profile, one.system) == ("same-machine", "operator")
    ]
    return goals.judge(goal, run)


def test_the_median_is_judged_and_the_better_peer() -> None:
    """A goal relative to the peers is missed where the better one is too near, not the worse."""
    ours = [result("operator", n, picture_ms=age) for n, age in enumerate((10, 12, 90))]
    slow, quick = result("stock", picture_ms=80), result("livekit", picture_ms=20)
    name = "picture_age_p50_ms"
    assert judged([*ours, slow], name).verdict == "met"
    assert judged([*ours, slow, quick], name).verdict == "missed"
    assert judged(ours, name).verdict == "not judged"
    assert judged([*ours, slow], name).found["operator"].n == 3


def test_a_failure_is_a_miss() -> None:
    """Where no picture came the goal is missed; where nothing could be run it is not judged."""
    name = "picture_age_p95_ms"
    cell = a_cell("G", "same-machine", "operator")
    assert judged([synthetic.failed(cell, "there was no picture")], name).verdict == "missed"
    absent = synthetic.failed(cell, "there is no browser", "not run")
    assert judged([absent], name).verdict == "not judged"


def test_a_further_observer_costs_the_difference() -> None:
    """Of each repetition by itself: what the larger crowd takes more, for each of its viewers."""
    crowds = [
        result("operator", n, 0.3 + 0.1 * n + add, viewers=viewers)
        for n in range(3)
        for viewers, add in ((11, 0.0), (41, 0.06))
    ]
    stock = [result("stock", 0, cpu, viewers=viewers) for viewers, cpu in ((2, 0.3), (4, 0.5))]
    found = judged([*crowds, *stock], "goal_cost_share")
    assert found.found["operator"].median == pytest.approx(0.002)
    assert found.found["stock"].median == pytest.approx(0.1)
    assert found.verdict == "met"


def test_never_is_worse_than_any_time() -> None:
    """A step after which the picture stays old is a miss that says so, not a missing number."""
    cell = a_cell("G", "step-down", "operator", seconds=32.0)
    told: dict[str, float | str] = {"changes_began_ms": synthetic.START_MS + 3000.0}
    run = entries(synthetic.run([synthetic.measured(cell, picture_ms=900.0, told=told)]))
    found = {one.measure.name: goals.judge(one, run) for one in goals.goals(run)}
    assert math.isinf(found["goal_fresh_after_ms"].found["operator"].median)
    assert found["goal_fresh_after_ms"].verdict == "missed"
    assert any("never (goal: ≤ 2000 ms)" in line for line in section.text(run))


def test_the_table_is_on_the_page() -> None:
    """A run for the goals has them first, with verdicts; other runs have no such section."""
    ours = [result("operator", n, picture_ms=10, sound_ms=95) for n in range(3)]
    page = page_of(synthetic.run([*ours, result("stock", picture_ms=80)]))
    assert "goals" in page.ids
    assert page.behind("met")
    assert page.behind("missed")
    assert "goals" not in page_of(synthetic.run([synthetic.measured(a_cell())])).ids
