"""What a change of the link does to the picture: recovery, freshness, full quality."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from e2e.delay import changes
from e2e.instrument.sums import picture_ages, sized
from e2e.instrument.synthetic import OPENED_MS, shown

if TYPE_CHECKING:
    from e2e.instrument.bursts import Series

DROP = [(5, 30, 50, 640), (6, 30, 400, 640)]


def test_a_standing_picture_grows_old() -> None:
    """Before a late picture the series has the age that the previous one had reached."""
    ages = [(0.0, 50.0), (33.0, 50.0), (1033.0, 60.0)]
    assert changes.standing(ages) == [*ages[:2], (1033.0, 1050.0), ages[2]]


def _ages(*parts: tuple[float, float, float]) -> list[tuple[float, float]]:
    """Return a picture every 50 ms, from and to (ms), with an age."""
    return [
        (begin + 50.0 * number, age_ms)
        for begin, end, age_ms in parts
        for number in range(int((end - begin) / 50.0))
    ]


def test_recovered_is_good_again_and_for_a_second() -> None:
    """A short good moment between bad ones does not count; a good second counts from its start."""
    ages = _ages((0, 5000, 50), (5000, 6000, 900), (6000, 6400, 60), (6400, 7000, 900))
    ages += _ages((7000, 9000, 80))
    assert changes.recovery_ms(ages, 5000.0, 5000.0) == 2000.0


@pytest.mark.parametrize(
    "ages",
    [_ages((5000, 9000, 50)), [*_ages((0, 5000, 50)), (5100.0, 50.0), (9000.0, 50.0)]],
    ids=["nothing before", "silence after"],
)
def test_what_cannot_be_told_is_no_recovery(ages: Series) -> None:
    """Without a before there is nothing to return to; single pictures make no good second."""
    assert changes.recovery_ms(ages, 5000.0, 5000.0) is None


@pytest.mark.parametrize(
    ("parts", "expected_ms"),
    [
        ([(20, 30, 50, 640)], 0),
        ([(5, 30, 50, 640), (6.5, 30, 400, 640), (20, 30, 100, 160)], 1500),
        ([*DROP, (6.5, 30, 90, 640), (7, 30, 500, 64)], None),
        ([*DROP, (6.5, 30, 90, 640), (7, 30, 500, 64), (20, 30, 90, 64)], 2000),
        ([(5, 30, 50, 640), (20, 30, 400, 640)], None),
        # One picture is frozen, and ages, until the next comes at 9 s.
        ([(5, 30, 50, 640), (9, 0.001, 0, 640), (20, 30, 50, 640)], 4000),
    ],
)
def test_fresh_again_is_held_for_a_second(
    parts: list[tuple[float, float, float, int]], expected_ms: float | None
) -> None:
    """Counted from the step at 5 s, until for a second no picture is, or grows, 300 ms old."""
    ages = picture_ages(shown(*parts))
    found = changes.fresh_after_ms(ages, OPENED_MS + 5000, OPENED_MS + 20_000)
    assert found == (None if expected_ms is None else pytest.approx(expected_ms, abs=40))


def test_full_quality_is_size_and_rate() -> None:
    """It is full again only when a whole second has large pictures at the full rate."""
    pictures = shown((10, 10, 90, 160), (12, 30, 90, 320), (14, 10, 90, 640), (20, 30, 50, 640))
    large = sized(pictures, (640, 480))
    assert changes.full_after_ms(large, OPENED_MS + 10_000) == pytest.approx(4000, abs=150)
    assert changes.full_after_ms(large, OPENED_MS + 19_500) is None
