"""The opening hours as a calendar (RFC 5545) to which people subscribe.

Each window is an event that repeats weekly in the robot's time zone, whose rules are beside it, so
that everybody's calendar shows it in theirs. Where the clock is changed during a window, readers
differ in what repeating means (RFC 5545, 3.3.10 and 3.8.5.3): such a day is left out of it, and is
an event of its own, in UTC.
"""

from __future__ import annotations

from datetime import timedelta
from typing import TYPE_CHECKING, Final
from uuid import NAMESPACE_URL, uuid5

from icalendar import Calendar, Event

from wax.config.opening_hours import DAYS

if TYPE_CHECKING:
    from datetime import date, datetime

    from icalendar import TimezoneDaylight, TimezoneStandard

    from wax.config.opening_hours import OpeningHours, Window
    from wax.config.page import PageSettings

_MADE_BY: Final = "-//WAX//opening hours//EN"
_EXACT_DAYS: Final = 2 * 366
"""So far ahead is looked for changes of the clock; each start of the server looks anew."""
_ZONE_DAYS: Final = 10 * 366
"""So far ahead the rules of the time zone are told."""


def opening_calendar(
    hours: OpeningHours, page: PageSettings, public_url: str, now: datetime
) -> bytes:
    """Return the file, from the day of `now` on; takes some 10 ms."""
    today = now.astimezone(hours.zone).date()
    calendar = Calendar.new(prodid=_MADE_BY, name=page.name)
    calendar.add("refresh-interval", timedelta(days=1), {"value": "DURATION"})
    # The same tomorrow, so that whoever imports the file again has nothing twice.
    robot = uuid5(NAMESPACE_URL, public_url or page.name)
    calendar["uid"] = str(robot)
    for window in dict.fromkeys(hours.windows):
        for event in _events(hours, window, today):
            which = "weekly" if event.rrules else event.start.isoformat()
            event.add("uid", str(uuid5(robot, f"{window} {which}")))
            event.add("dtstamp", now)
            event.add("summary", page.name)
            event.add("transp", "TRANSPARENT")  # nobody is busy because the robot is open
            if page.sentence:
                event.add("description", page.sentence)
            if public_url:
                event.add("url", f"{public_url}/")
            calendar.add_component(event)
    calendar.add_missing_timezones(today - timedelta(days=1), today + timedelta(days=_ZONE_DAYS))
    for zone in calendar.timezones:
        rules: list[TimezoneStandard | TimezoneDaylight] = [*zone.standard, *zone.daylight]
        for rule in rules:
            _put_forward_in_time(rule)
    file: bytes = calendar.to_ical()
    return file


def _put_forward_in_time(rule: TimezoneStandard | TimezoneDaylight) -> None:
    """Begin a rule that puts the clock forward by the clock before it (RFC 5545, 3.6.5).

    icalendar begins it at the first time that is shown after it.
    """
    gap = rule.TZOFFSETTO - rule.TZOFFSETFROM
    if gap > timedelta():
        rule.DTSTART -= gap
        rule.rdates = [begins - gap for begins, _ in rule.rdates]


def _events(hours: OpeningHours, window: Window, today: date) -> list[Event]:
    days = [today + timedelta(days=ahead) for ahead in range(_EXACT_DAYS)]
    days = [day for day in days if day.weekday() in window.days]
    odd = [day for day in days if not _is_usual(hours, window, day)]
    first = next(day for day in days if day not in odd)
    weekly = Event()
    weekly.add("dtstart", hours.local(first, window.opens))
    weekly.add("dtend", hours.local(first, window.closes_after))
    weekly.add("rrule", {"freq": "weekly", "byday": [_byday(day) for day in sorted(window.days)]})
    if odd:
        weekly.add("exdate", [hours.local(day, window.opens) for day in odd])
    return [weekly, *(_once(*span) for day in odd if (span := hours.on(day, window)) is not None)]


def _is_usual(hours: OpeningHours, window: Window, day: date) -> bool:
    """Whether the window begins when a clock shows its time, and is as long as the clock says."""
    span = hours.on(day, window)
    if span is None:
        return False
    opens, closes = span
    shown = opens.astimezone(hours.zone).replace(tzinfo=None)
    is_shown = shown == hours.local(day, window.opens).replace(tzinfo=None)
    return is_shown and closes - opens == timedelta(minutes=window.closes_after - window.opens)


def _once(opens: datetime, closes: datetime) -> Event:
    event = Event()
    event.add("dtstart", opens)
    event.add("dtend", closes)
    return event


def _byday(day: int) -> str:
    return DAYS[day][:2].upper()
