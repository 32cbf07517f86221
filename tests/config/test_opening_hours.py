"""Opening hours across weeks, nights and clock changes."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from zoneinfo import ZoneInfo

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.examples import examples

from wax.config.opening_hours import OpeningHours, Window, zone_of

BERLIN = ZoneInfo("Europe/Berlin")


def at(text: str) -> datetime:
    """Return a local time in Berlin; 2026-11-23 is a Monday."""
    return datetime.fromisoformat(text).replace(tzinfo=BERLIN)


def make(*texts: str) -> OpeningHours:
    return OpeningHours.of(texts, BERLIN)


def test_without_hours_it_is_always_open() -> None:
    """Without hours it is always open, and so has no next opening."""
    hours = make()
    now = at("2026-11-23 03:00")
    assert (hours.is_open(now), hours.opens_next(now)) == (True, None)


@pytest.mark.parametrize(
    ("now", "is_open", "opens"),
    [
        ("2026-11-23 08:59", False, "2026-11-23 09:00"),
        ("2026-11-23 09:00", True, "2026-11-24 09:00"),
        ("2026-11-23 17:59", True, "2026-11-24 09:00"),
        ("2026-11-23 18:00", False, "2026-11-24 09:00"),
        ("2026-11-27 18:00", False, "2026-11-28 22:00"),
        ("2026-11-29 01:59", True, "2026-11-30 09:00"),
        ("2026-11-29 02:00", False, "2026-11-30 09:00"),
    ],
)
def test_a_week(now: str, is_open: bool, opens: str) -> None:
    """Weekdays from nine to six, and the night from Saturday to Sunday."""
    hours = make("mon-fri 09:00-18:00", "sat 22:00-02:00")
    assert hours.is_open(at(now)) == is_open
    assert hours.opens_next(at(now)) == at(opens)


def test_days_go_round() -> None:
    """Days wrap around: from Saturday to Monday is three days."""
    assert Window.parse("sat-mon 10:00-12:00").days == {5, 6, 0}


def test_windows_that_touch_are_one() -> None:
    """Windows that touch are one: open day and night means open at midnight."""
    hours = make("fri-sun 00:00-24:00")
    assert hours.is_open(at("2026-11-28 00:00"))
    assert hours.is_open(at("2026-11-29 23:59"))
    assert not hours.is_open(at("2026-11-30 00:00"))


def test_the_clock_is_put_forward() -> None:
    """On 2026-03-29 the hour from two to three is missing."""
    hours = make("sun 02:30-04:00")
    opens = hours.opens_next(at("2026-03-28 12:00"))
    assert opens == datetime(2026, 3, 29, 1, 30, tzinfo=UTC)
    assert hours.is_open(datetime(2026, 3, 29, 1, 59, tzinfo=UTC))
    assert not hours.is_open(datetime(2026, 3, 29, 2, 0, tzinfo=UTC))


def test_the_clock_is_put_forward_over_a_window() -> None:
    """A window that clocks skip entirely does not open that day."""
    hours = make("sun 02:30-03:00")
    assert hours.opens_next(at("2026-03-28 12:00")) == at("2026-04-05 02:30")


def test_the_week_to_come() -> None:
    """The coming week has each later opening once, in order, with touching windows merged."""
    hours = make("mon-fri 09:00-18:00", "fri 18:00-24:00", "sat 00:00-02:00")
    assert hours.openings(at("2026-11-26 12:00")) == [
        (at("2026-11-27 09:00"), at("2026-11-28 02:00")),
        (at("2026-11-30 09:00"), at("2026-11-30 18:00")),
        (at("2026-12-01 09:00"), at("2026-12-01 18:00")),
        (at("2026-12-02 09:00"), at("2026-12-02 18:00")),
        (at("2026-12-03 09:00"), at("2026-12-03 18:00")),
    ]
    assert make().openings(at("2026-11-26 12:00")) == []


@pytest.mark.parametrize(
    "text",
    [
        "",
        "mon",
        "mon 9:00-18:00",
        "mon 09:00-25:00",
        "mon 09:60-10:00",
        "MON 09:00-18:00",
        "mon-xyz 09:00-18:00",
        "mon 24:00-10:00",
        "mon  09:00-18:00",
        "mon 09:00-18:00 ",
    ],
)
def test_what_is_no_window(text: str) -> None:
    """An invalid window is a sentence with an example."""
    with pytest.raises(ValueError, match="mon-fri"):
        Window.parse(text)


DAY = st.sampled_from(["mon", "tue-thu", "fri", "sat-mon"])
CLOCK = st.integers(0, 47).map(lambda half: f"{half // 2:02}:{half % 2 * 30:02}")


@examples(200)
@given(
    st.lists(st.tuples(DAY, CLOCK, CLOCK), min_size=1, max_size=3),
    st.integers(0, 365 * 24 * 60).map(
        lambda minutes: datetime(2026, 1, 1, tzinfo=UTC) + timedelta(minutes=minutes)
    ),
)
def test_what_is_told_comes_true(windows: list[tuple[str, str, str]], now: datetime) -> None:
    """It opens exactly at the announced next opening, and not before."""
    hours = make(*(f"{days} {opens}-{closes}" for days, opens, closes in windows))
    opens = hours.opens_next(now)
    assert opens is not None
    assert opens > now
    assert hours.is_open(opens)
    assert hours.is_open(now) or not hours.is_open(opens - timedelta(seconds=1))


def test_utc_needs_no_data() -> None:
    """UTC works on a machine without a time zone database."""
    assert zone_of("UTC") is UTC
    assert zone_of("Europe/Berlin") == BERLIN
