"""The calendar of the opening hours, as another program reads it."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta, timezone
from typing import TYPE_CHECKING, Any
from zoneinfo import ZoneInfo

import pytest
from hypothesis import given
from hypothesis import strategies as st
from icalendar import Calendar
from tests.examples import examples

from wax.config.opening_hours import OpeningHours, zone_of
from wax.config.page import PageSettings
from wax.web.opening_calendar import opening_calendar

if TYPE_CHECKING:
    from icalendar import Event, TimezoneDaylight, TimezoneStandard

BERLIN = "Europe/Berlin"
AUTUMN = datetime(2026, 10, 20, 12, 0, tzinfo=UTC)
"""Five days before the clock is put back in Berlin, where it is put forward on 2027-03-28."""
URL = "https://robot.example.org"


def made(
    *texts: str,
    zone: str = BERLIN,
    now: datetime = AUTUMN,
    name: str = "Rover",
    public_url: str = URL,
) -> bytes:
    hours = OpeningHours.of(texts, zone_of(zone))
    return opening_calendar(hours, PageSettings(name=name, sentence="Say hello."), public_url, now)


def events(file: bytes) -> list[Event]:
    return Calendar.from_ical(file).events


def span(event: Event) -> tuple[datetime, datetime]:
    opens, closes = event.start, event.end
    assert isinstance(opens, datetime)
    assert isinstance(closes, datetime)
    return opens, closes


def spans(file: bytes, days: int) -> list[tuple[datetime, datetime]]:
    """Return what a reader shows of so many days: events as often as they repeat, but on some."""
    found = []
    for event in events(file):
        first, last = span(event)
        length = last.astimezone(UTC) - first.astimezone(UTC)
        if event.rrules:
            (rule,) = event.rrules
            each = [first + timedelta(days=ahead) for ahead in range(days)]
            each = [one for one in each if one.strftime("%a")[:2].upper() in rule["BYDAY"]]
            shown = [one for one in each if one not in event.exdates]
        else:
            shown = [first]
        found += [(one.astimezone(UTC), one.astimezone(UTC) + length) for one in shown]
    return found


def test_a_week_of_hours_is_an_event_that_repeats() -> None:
    """In the robot's time zone, whose rules are in the file; nobody is busy because of it."""
    weekly, night = events(made("mon-fri 09:00-18:00", "sat 22:00-02:00"))
    text = made("mon-fri 09:00-18:00").decode()
    assert "DTSTART;TZID=Europe/Berlin:20261020T090000\r\n" in text
    assert "DTEND;TZID=Europe/Berlin:20261020T180000\r\n" in text
    assert "RRULE:FREQ=WEEKLY;BYDAY=MO,TU,WE,TH,FR\r\n" in text
    assert "BEGIN:VTIMEZONE\r\nTZID:Europe/Berlin\r\n" in text
    assert "REFRESH-INTERVAL;VALUE=DURATION:P1D\r\n" in text
    assert (weekly["summary"], weekly["description"]) == ("Rover", "Say hello.")
    assert (weekly["url"], weekly["transp"]) == (f"{URL}/", "TRANSPARENT")
    opens, closes = span(night)
    assert closes - opens == timedelta(hours=4)


def test_the_zones_rules_put_the_clock_back_and_forward() -> None:
    """On the second, for a reader that does not know the zone's name."""
    (zone,) = Calendar.from_ical(made("mon 09:00-18:00")).timezones
    rules: list[TimezoneStandard | TimezoneDaylight] = [*zone.standard, *zone.daylight]
    begins = {one.DTSTART.replace(tzinfo=timezone(one.TZOFFSETFROM)) for one in rules}
    begins |= {
        day.replace(tzinfo=timezone(one.TZOFFSETFROM)) for one in rules for day, _ in one.rdates
    }
    assert datetime(2026, 10, 25, 1, tzinfo=UTC) in begins
    assert {
        datetime(year, 3, day, 1, tzinfo=UTC) for year, day in ((2027, 28), (2028, 26))
    } < begins


def test_a_night_on_which_the_clock_is_changed_is_an_event_of_its_own() -> None:
    """From ten to five that night is eight hours, and not left to how a reader counts."""
    weekly, *nights = events(made("sat 22:00-05:00"))
    # A year has two, and two years are looked ahead.
    assert weekly.exdates[0] == datetime(2026, 10, 24, 22, tzinfo=ZoneInfo(BERLIN))
    assert [span(one) for one in nights[:2]] == [
        (datetime(2026, 10, 24, 20, tzinfo=UTC), datetime(2026, 10, 25, 4, tzinfo=UTC)),
        (datetime(2027, 3, 27, 21, tzinfo=UTC), datetime(2027, 3, 28, 3, tzinfo=UTC)),
    ]


def test_it_is_the_same_after_a_restart() -> None:
    """Whoever imports the file again has no event twice; another robot's events are others."""
    texts = ("mon-fri 09:00-18:00", "sat 22:00-05:00")

    def uids(**of: Any) -> list[str]:
        return [str(one.uid) for one in events(made(*texts, **of))]

    own = uids()
    assert len(set(own)) == len(own)
    assert uids(now=AUTUMN + timedelta(days=3)) == own
    assert not set(own) & set(uids(public_url="https://other.example.org"))
    assert not set(own) & set(uids(public_url=""))


def test_what_a_host_writes_is_text() -> None:
    """A name with the format's own marks, in any writing, adds no property and no event."""
    name = "R;o,v\\e:r 🤖 " + "ü" * 20
    (event,) = events(made("mon 09:00-18:00", name=name))
    assert event["summary"] == name


@pytest.mark.parametrize("zone", ["UTC", "Asia/Kolkata", "America/New_York"])
def test_any_zone_has_its_rules(zone: str) -> None:
    """None are needed for UTC, and one that never changes its clock has one."""
    calendar = Calendar.from_ical(made("mon 09:00-18:00", zone=zone))
    assert calendar.get_missing_tzids() == set()
    assert len(calendar.walk("VTIMEZONE")) == (zone != "UTC")


DAY = st.sampled_from(["mon", "tue-thu", "sat", "sun", "sat-mon"])
CLOCK = st.integers(0, 47).map(lambda half: f"{half // 2:02}:{half % 2 * 30:02}")


@examples(100)
@given(
    st.lists(st.tuples(DAY, CLOCK, CLOCK), min_size=1, max_size=3),
    st.sampled_from([BERLIN, "America/New_York", "Australia/Lord_Howe"]),
    st.integers(0, 365).map(lambda days: AUTUMN + timedelta(days=days)),
)
def test_the_calendar_says_what_the_door_does(
    windows: list[tuple[str, str, str]], zone: str, now: datetime
) -> None:
    """For half a year, with its change of the clock: the same openings, to the minute."""
    texts = [f"{days} {opens}-{closes}" for days, opens, closes in windows]
    hours = OpeningHours.of(texts, zone_of(zone))
    today = now.astimezone(hours.zone).date()
    each = [(today + timedelta(days=day), one) for day in range(190) for one in hours.windows]
    said = {hours.on(day, one) for day, one in each if day.weekday() in one.days} - {None}
    shown = set(spans(opening_calendar(hours, PageSettings(), "", now), 190))
    until = now + timedelta(days=185)
    assert {one for one in shown if one[0] < until} == {
        one for one in said if one and one[0] < until
    }
