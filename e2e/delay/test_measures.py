"""The numbers of a cell, each made of its readings, and how they are written."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from e2e.delay.cell import Cell
from e2e.delay.figures import Pauses
from e2e.delay.measures import MEASURES, breaks, measured, set_points_per_s
from e2e.delay.readings import Connections, Pictures, Readings, SetPoints
from e2e.delay.results import Carried, CellResult, Server
from e2e.instrument.sums import figures
from e2e.instrument.synthetic import OPENED_MS, counters, readings, shown

if TYPE_CHECKING:
    from e2e.delay.figures import Figures

CELL = Cell(experiment="E2", profile="lan", system="stock")
NONE = Carried(packets=0, bytes=0, queue_drops=0, losses=0)


def result(read: Readings, cell: Cell = CELL, **more: object) -> CellResult:
    return CellResult(
        cell=cell,
        figures=figures(read),
        readings=read,
        down=NONE,
        up=NONE,
        server=Server(cpu_share=0.2, memory_mib=100.0),
    ).model_copy(update=more)


def span(seconds: float) -> Figures:
    return figures(readings(seconds), settle_s=0)


def value(name: str, of: CellResult) -> float | None:
    return MEASURES[name].of(of)


def test_a_perfect_cell_has_its_numbers() -> None:
    """Ages, skew and costs are those that were put in; what was not looked for is left out."""
    found = measured(result(readings(15, picture_age_ms=80, sound_age_ms=120)))
    assert found["picture_age_p50_ms"] == pytest.approx(80, abs=1)
    assert found["skew_p50_ms"] == pytest.approx(40, abs=2)
    assert found["server_cpu"] == 20
    assert found["pauses"] == 0
    assert found["late_pictures_per_s"] == 0
    assert {"command_round_trip_p50_ms", "fresh_after_ms", "lip_lag_ms"}.isdisjoint(found)


def test_skew_counts_from_three_seconds_after_joining() -> None:
    """Skew in the first 3 s is ignored, and any later skew counts."""
    found = readings(20, picture_age_ms=80, sound_age_ms=120)
    assert value("joined_skew_p95_ms", result(found)) == pytest.approx(40, abs=2)
    late = found.model_copy(update={"first_picture_ms": OPENED_MS + 60_000})
    assert value("joined_skew_p95_ms", result(late)) is None


def test_concealment_counts_from_the_first_sound() -> None:
    """Of 2 s after the first sound 100 ms were made up; what was before it does not count."""
    rows = [(100.0, 1)] * 10 + [(0.0, 0)] * 10 + [(100.0, 1)] + [(0.0, 0)] * 10
    read = Readings(opened_ms=OPENED_MS, first_sound_ms=OPENED_MS + 1000, counters=counters(rows))
    assert value("concealed_percent", result(read)) == pytest.approx(5, abs=0.5)
    silent = read.model_copy(update={"first_sound_ms": None})
    assert value("concealed_percent", result(silent)) is None


def test_a_rate_is_of_pictures_of_that_size() -> None:
    """Smaller pictures do not count for the larger size."""
    read = readings(20).model_copy(update={"pictures": shown((10, 30, 50, 640), (20, 10, 50, 320))})
    found = result(read, figures=span(20))
    assert value("pictures_640_per_s", found) == pytest.approx(15, abs=0.1)
    assert value("pictures_160_per_s", found) == pytest.approx(20, abs=0.1)


def test_pauses_are_a_share_of_the_time_that_sound_was_judged() -> None:
    """Two gaps in the 6 s that were left of 15 are 20 a minute; in no time there is no figure."""
    whole = span(15)
    late = {
        "sound_from_ms": whole.to_ms - 6000,
        "tone_pauses": Pauses(at_ms=[0, 0], length_ms=[40, 60]),
    }
    found = result(readings(15), figures=whole.model_copy(update=late))
    assert value("tone_pauses_per_min", found) == pytest.approx(20)
    assert value("heard_tone_pauses_per_min", found) == pytest.approx(10)
    assert value("tone_pause_share", found) == pytest.approx(100 / 60)
    never = result(readings(15), figures=whole.model_copy(update={"sound_from_ms": whole.to_ms}))
    assert value("tone_pauses_per_min", never) is None


def test_speech_has_no_tone_to_have_gaps() -> None:
    """That no gap was found where no tone is, is not told as none."""
    speech = CELL.model_copy(update={"content": "talking-head"})
    assert value("tone_pauses_per_min", result(readings(15), speech)) is None
    assert value("tone_pauses_per_min", result(readings(15))) == 0


def test_a_break_is_seen() -> None:
    """Connected once and all along is 0; each change of it counts, and so does a dead end."""
    read = readings(10)
    states = ["connecting", "connected", "disconnected", "connected"]
    for number, expected in ((2, 0), (4, 2)):
        some = states[:number]
        read.connections = Connections(at_ms=[0.0] * number, state=some)
        assert breaks(read, span(10)) == expected
        assert breaks(read, span(60)) == expected + 1
    read.connections = Connections()
    assert breaks(read, span(10)) is None


def test_driving_is_seen() -> None:
    """The rate of set-points is over the measured time; an observer sends none."""
    read = readings(10)
    assert set_points_per_s(read, span(10)) is None
    sent = [OPENED_MS + 50 * number for number in range(400)]
    read.set_points = SetPoints(at_ms=sent)
    assert set_points_per_s(read, span(10)) == pytest.approx(20, abs=0.2)


@pytest.mark.parametrize(("until_s", "expected_ms"), [(7.4, 400.0), (60.0, None)])
def test_recovery_is_counted_from_the_last_change(
    until_s: float, expected_ms: float | None
) -> None:
    """Of an outage from 5 to 7 s with pictures again at 7.4 s: 0.4 s; never is told as never."""
    read = readings(25)
    kept = [n for n, at in enumerate(read.pictures.at_ms) if not 5 <= _s(at) < until_s]
    read.pictures = Pictures(
        **{name: [column[n] for n in kept] for name, column in read.pictures if column}
    )
    cell = Cell(experiment="E6", profile="outage", system="operator")
    found = measured(result(read, cell, told={"changes_began_ms": OPENED_MS}))
    recovered = found["picture_recovered_ms"]
    assert recovered == (None if expected_ms is None else pytest.approx(expected_ms, abs=40))
    assert "picture_recovered_ms" not in measured(result(read, cell))


def _s(at_ms: float) -> float:
    return (at_ms - OPENED_MS) / 1000


@pytest.mark.parametrize(
    ("name", "value", "text"),
    [
        ("picture_age_p50_ms", 123.4, "123"),
        ("picture_age_p50_ms", 10.4, "10"),
        ("picture_age_p50_ms", 4.25, "4.2"),
        ("picture_age_p50_ms", 100.0, "100"),
        ("picture_age_p50_ms", 0.0, "0"),
        ("skew_p50_ms", 23.0, "+23"),
        ("skew_p50_ms", -23.0, "−23"),
        ("skew_p50_ms", -0.001, "0"),
        ("pictures_per_s", 0.5, "0.5"),
        ("pictures_per_s", 30.0, "30"),
        ("server_cpu", 17.4, "17.4"),
    ],
)
def test_numbers_are_written_for_people(name: str, value: float, text: str) -> None:
    """No digit that means nothing, a true minus, a sign where it tells something."""
    assert MEASURES[name].text(value) == text
