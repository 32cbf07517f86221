"""The opening hours as a calendar (RFC 5545) to which people subscribe.

Each opening of the coming weeks is an event of its own, in UTC. A repeating event would need the
time zone's rules, which programs read differently: some are an hour off for half of the year, and
a zone that changes its clock by the moon, such as Morocco's, has no rule.
"""

from __future__ import annotations

from datetime import UTC, timedelta
from typing import TYPE_CHECKING, Final
from uuid import NAMESPACE_URL, uuid5

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from datetime import date, datetime

    from wax.config.opening_hours import OpeningHours
    from wax.config.page import PageSettings

_WEEKS: Final = 8
"""Enough even for a program that reads the file again only after a month."""
_LINE_BYTES: Final = 75
"""Longer lines go on in the next, which begins with a space (RFC 5545, 3.1)."""
_ESCAPES: Final = str.maketrans({"\\": "\\\\", ";": "\\;", ",": "\\,"})


class OpeningCalendar:
    """`now` returns an aware time; the file is built at most once a day, on request."""

    def __init__(
        self, hours: OpeningHours, page: PageSettings, public_url: str, now: Callable[[], datetime]
    ) -> None:
        self._hours = hours
        self._page = page
        self._url = public_url
        self._now = now
        self._day: date | None = None
        self._file = b""

    def file(self) -> bytes:
        """Return the file, beginning with yesterday; building it takes a few milliseconds."""
        now = self._now()
        day = now.astimezone(self._hours.zone).date()
        if day != self._day:
            self._day = day
            self._file = b"".join(map(_folded, self._lines(day, _time(now))))
        return self._file

    def _lines(self, today: date, made: str) -> Iterator[str]:
        name = self._page.name.translate(_ESCAPES)
        # Stable, so that importing the file again duplicates nothing.
        robot = uuid5(NAMESPACE_URL, self._url or self._page.name)
        yield "BEGIN:VCALENDAR"
        yield "VERSION:2.0"
        yield "PRODID:-//WAX//opening hours//EN"
        yield f"UID:{robot}"
        yield f"NAME:{name}"
        yield f"X-WR-CALNAME:{name}"
        yield "REFRESH-INTERVAL;VALUE=DURATION:P1D"
        yield "X-PUBLISHED-TTL:P1D"
        for opens, closes in self._openings(today):
            begins, ends = _time(opens), _time(closes)
            yield "BEGIN:VEVENT"
            yield f"UID:{uuid5(robot, f'{begins}/{ends}')}"
            yield f"DTSTAMP:{made}"
            yield f"DTSTART:{begins}"
            yield f"DTEND:{ends}"
            yield f"SUMMARY:{name}"
            yield "TRANSP:TRANSPARENT"  # nobody is busy because the robot is open
            if self._page.sentence:
                yield f"DESCRIPTION:{self._page.sentence.translate(_ESCAPES)}"
            if self._url:
                yield f"URL:{self._url}/"
            yield "END:VEVENT"
        yield "END:VCALENDAR"

    def _openings(self, today: date) -> list[tuple[datetime, datetime]]:
        """Return all openings, beginning with yesterday's, which may last past midnight."""
        days = [today + timedelta(days=ahead) for ahead in range(-1, 7 * _WEEKS)]
        found = {
            self._hours.on(day, window)
            for window in self._hours.windows
            for day in days
            if day.weekday() in window.days
        }
        return sorted(span for span in found if span is not None)


def _time(moment: datetime) -> str:
    return f"{moment.astimezone(UTC):%Y%m%dT%H%M%SZ}"


def _folded(line: str) -> bytes:
    """Return a line with its line break, folded without splitting a character."""
    rest, cut = line.encode(), b""
    room = _LINE_BYTES
    while len(rest) > room:
        end = room
        while rest[end] & 0xC0 == 0x80:  # within a character
            end -= 1
        cut += rest[:end] + b"\r\n "
        rest = rest[end:]
        room = _LINE_BYTES - 1
    return cut + rest + b"\r\n"
