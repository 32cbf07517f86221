"""What is made of the raw series: ages, skew, late pictures, stalls, recovery, thinning."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as st

from e2e.lab.cell import Cell
from e2e.lab.report import series
from e2e.lab.report.measures import MEASURES
from e2e.lab.report.synthetic import measured

if TYPE_CHECKING:
    from e2e.lab.results import CellResult

CELL = Cell(experiment="E2", profile="lan", system="stock")


def _sounds(result: CellResult) -> list[float]:
    assert result.readings is not None
    return [age_ms for _, age_ms in series.sound_ages(result.readings)]


@pytest.mark.parametrize("age_ms", [83.0, 640.0, 1480.0, -4.0])
def test_the_age_of_the_sound_is_read_to_a_millisecond(age_ms: float) -> None:
    """A burst that begins within a row of 10 ms is timed to the row's fraction."""
    ages = _sounds(measured(CELL, sound_ms=age_ms, picture_ms=max(10.0, age_ms)))
    assert len(ages) >= 16
    assert ages == pytest.approx([age_ms] * len(ages), abs=1.0)


def test_a_face_has_no_bursts() -> None:
    """Where no 1 kHz is, no age of the sound is made up."""
    assert _sounds(measured(CELL.model_copy(update={"content": "face"}))) == []


def test_skew_is_the_sounds_age_less_the_pictures() -> None:
    """Above 0 the sound comes after the picture; sound long after the last picture has none."""
    pictures = [(1000.0, 60.0), (1033.0, 50.0), (1066.0, 40.0)]
    assert series.skews(pictures, [(1040.0, 80.0)]) == [(1040.0, 30.0)]
    assert series.skews(pictures, [(1040.0, 30.0)]) == [(1040.0, -20.0)]
    assert series.skews(pictures, [(9000.0, 80.0)]) == []


def test_a_standing_picture_grows_old() -> None:
    """Before a picture that comes late stands how old the one before had become."""
    ages = [(0.0, 50.0), (33.0, 50.0), (1033.0, 60.0)]
    assert series.standing(ages) == [*ages[:2], (1033.0, 1050.0), ages[2]]


def test_late_pictures_and_stalls_are_counted_by_the_second() -> None:
    """One second without a picture in fifteen is one stall; pictures of one age are never late."""
    result = measured(CELL, picture_ms=60.0, grows_from_s=5.0, grows_until_s=6.0)
    assert MEASURES["picture_stalls_per_s"].of(result) == pytest.approx(1 / 15)
    assert MEASURES["late_pictures_per_s"].of(result) == 0.0


def test_a_picture_shown_again_is_no_new_picture() -> None:
    """Where the same stamp is presented for a second, one picture stood for that second."""
    result = measured(CELL, picture_ms=60.0)
    assert result.readings is not None
    assert result.figures is not None
    pictures = result.readings.pictures
    first = 30 * 8
    pictures.stamp_ms[first : first + 30] = [pictures.stamp_ms[first]] * 30
    assert MEASURES["picture_stalls_per_s"].of(result) == pytest.approx(1 / 15)


def _ages(*parts: tuple[float, float, float]) -> list[tuple[float, float]]:
    """From, to (ms) and age: a picture every 50 ms."""
    return [
        (begin + 50.0 * number, age_ms)
        for begin, end, age_ms in parts
        for number in range(int((end - begin) / 50.0))
    ]


def test_recovered_is_good_again_and_for_a_second() -> None:
    """A short good moment between bad ones is none; the good second's begin is what counts."""
    ages = _ages((0, 5000, 50), (5000, 6000, 900), (6000, 6400, 60), (6400, 7000, 900))
    ages += _ages((7000, 9000, 80))
    assert series.recovery_ms(ages, 5000.0, 5000.0, math.inf) == 2000.0
    assert series.recovery_ms(ages, 5000.0, 5000.0, 6500.0) is None


def test_no_recovery_without_a_before() -> None:
    """Where nothing was measured before the change, there is nothing to come back to."""
    assert series.recovery_ms(_ages((5000, 9000, 50)), 5000.0, 5000.0, math.inf) is None


def test_silence_is_no_recovery() -> None:
    """One good picture, nothing for long, and one more do not make a good second."""
    ages = [*_ages((0, 5000, 50)), (5100.0, 50.0), (9000.0, 50.0)]
    assert series.recovery_ms(ages, 5000.0, 5000.0, math.inf) is None


@given(
    values=st.lists(st.integers(-1000, 1000), min_size=1, max_size=2000), most=st.integers(4, 400)
)
def test_thinning_keeps_peaks_and_order(values: list[int], most: int) -> None:
    """What is drawn has the extremes and both ends, in order, and at most about `most` points."""
    whole = [(float(at), float(value)) for at, value in enumerate(values)]
    kept = series.thinned(whole, most)
    assert kept == sorted(kept)
    assert {kept[0], kept[-1]} == {whole[0], whole[-1]}
    assert {min(v for _, v in kept), max(v for _, v in kept)} == {min(values), max(values)}
    assert len(kept) <= most + 4


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
        ("server_cpu_share", 0.174, "17.4"),
        ("received_total_bytes_per_s", 5900.0, "5.9"),
    ],
)
def test_numbers_are_written_for_people(name: str, value: float, text: str) -> None:
    """No digit that means nothing, a true minus, a sign where it tells something."""
    assert MEASURES[name].text(value) == text
