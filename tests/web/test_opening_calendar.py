"""The calendar of the opening hours, read by another program's parser."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING, Any

from hypothesis import given
from hypothesis import strategies as st
from icalendar import Calendar
from tests.examples import examples

from wax.config.opening_hours import OpeningHours, zone_of
from wax.config.page import PageSettings
from wax.web.opening_calendar import OpeningCalendar

if TYPE_CHECKING:
    from icalendar import Event

BERLIN = "Europe/Berlin"
AUTUMN = datetime(2026, 10, 20, 12, 0, tzinfo=UTC)
"""A Tuesday, five days before the clock is put back in Berlin."""
URL = "https://robot.example.org"


def made(
    *texts: str,
    zone: str = BERLIN,
    now: datetime = AUTUMN,
    name: str = "Rover",
    public_url: str = URL,
) -> bytes:
    hours = OpeningHours.of(texts, zone_of(zone))
    page = PageSettings(name=name, sentence="Say hello.")
    return OpeningCalendar(hours, page, public_url, lambda: now).file()


def events(file: bytes) -> list[Event]:
    return Calendar.from_ical(file).events


def spans(file: bytes) -> list[tuple[Any, Any]]:
    return [(one.start, one.end) for one in events(file)]


def test_each_opening_is_an_event_in_utc() -> None:
    """No reader can mistake UTC for another time; the event makes nobody busy."""
    text = made("mon-fri 09:00-18:00").decode()
    assert "\r\nDTSTART:20261020T070000Z\r\nDTEND:20261020T160000Z\r\n" in text
    assert "\r\nREFRESH-INTERVAL;VALUE=DURATION:P1D\r\n" in text
    assert "RRULE" not in text
    assert "TZID" not in text
    first = events(made("mon-fri 09:00-18:00"))[0]
    assert (first["summary"], first["description"]) == ("Rover", "Say hello.")
    assert (first["url"], first["transp"]) == (f"{URL}/", "TRANSPARENT")


def test_events_follow_a_change_of_the_clock() -> None:
    """Ten to five lasts eight hours that night, and then nine is an hour later in UTC."""
    assert spans(made("sat 22:00-05:00", "mon 09:00-18:00"))[:2] == [
        (datetime(2026, 10, 19, 7, tzinfo=UTC), datetime(2026, 10, 19, 16, tzinfo=UTC)),
        (datetime(2026, 10, 24, 20, tzinfo=UTC), datetime(2026, 10, 25, 4, tzinfo=UTC)),
    ]
    assert (
        datetime(2026, 10, 26, 8, tzinfo=UTC),
        datetime(2026, 10, 26, 17, tzinfo=UTC),
    ) in spans(made("mon 09:00-18:00"))


def test_it_is_rebuilt_once_a_day() -> None:
    """An opening that began the night before is still in it."""
    now = AUTUMN
    hours = OpeningHours.of(["mon-sun 22:00-05:00"], zone_of(BERLIN))
    calendar = OpeningCalendar(hours, PageSettings(), "", lambda: now)
    first = calendar.file()
    now += timedelta(hours=9)
    assert calendar.file() is first
    now += timedelta(hours=5)
    second = calendar.file()
    assert spans(second)[0][0] == datetime(2026, 10, 20, 20, tzinfo=UTC)
    assert spans(second)[:-1] == spans(first)[1:]


def test_it_is_the_same_after_a_restart() -> None:
    """Importing the file again duplicates no event; another robot's events have other IDs."""
    texts = ("mon-fri 09:00-18:00", "sat 22:00-05:00")

    def uids(**of: Any) -> list[str]:
        return [str(one.uid) for one in events(made(*texts, **of))]

    own = uids()
    assert len(set(own)) == len(own)
    assert set(own[6:]) < set(uids(now=AUTUMN + timedelta(days=7)))
    assert not set(own) & set(uids(public_url="https://other.example.org"))
    assert not set(own) & set(uids(public_url=""))


def test_the_hosts_texts_are_escaped_in_it() -> None:
    """A name with the format's special characters adds no property and no event."""
    name = "R;o,v\\e:r 🤖 " + "🤖" * 20
    file = made("mon 09:00-18:00", name=name)
    assert {one["summary"] for one in events(file)} == {name}
    assert max(map(len, file.split(b"\r\n"))) <= 75
    for line in file.split(b"\r\n"):
        line.decode()  # no character is cut


DAY = st.sampled_from(["mon", "tue-thu", "sat", "sun", "sat-mon"])
CLOCK = st.integers(0, 47).map(lambda half: f"{half // 2:02}:{half % 2 * 30:02}")
ZONES = [BERLIN, "America/New_York", "Australia/Lord_Howe", "Africa/Casablanca", "UTC"]


@examples(100)
@given(
    st.lists(st.tuples(DAY, CLOCK, CLOCK), min_size=1, max_size=3),
    st.sampled_from(ZONES),
    st.integers(0, 365).map(lambda days: AUTUMN + timedelta(days=days)),
)
def test_the_calendar_agrees_with_admission(
    windows: list[tuple[str, str, str]], zone: str, now: datetime
) -> None:
    """For weeks, guests are admitted from each event's beginning to its end, and only then."""
    texts = [f"{days} {opens}-{closes}" for days, opens, closes in windows]
    hours = OpeningHours.of(texts, zone_of(zone))
    shown = spans(OpeningCalendar(hours, PageSettings(), "", lambda: now).file())
    for opens, closes in shown:
        assert hours.is_open(opens)
        assert hours.is_open(closes - timedelta(minutes=1))
    begins, ends = {opens for opens, _ in shown}, {closes for _, closes in shown}
    for week in range(7):
        for opens, closes in hours.openings(now + timedelta(days=7 * week)):
            assert opens in begins
            assert closes in ends
