"""When the robot is open to people, and when it opens next.

Hours are local times of the configured zone; a window that ends before it begins lasts past
midnight. When clocks go forward, a time that does not exist is the one an hour later.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from datetime import UTC, datetime, time, timedelta
from typing import TYPE_CHECKING, Final, Self
from zoneinfo import ZoneInfo

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from datetime import date, tzinfo

DAYS: Final = ("mon", "tue", "wed", "thu", "fri", "sat", "sun")
_DAY: Final = f"(?:{'|'.join(DAYS)})"
PATTERN: Final = (
    rf"^(?P<first>{_DAY})(?:-(?P<last>{_DAY}))?"
    r" (?P<opens>(?:[01]\d|2[0-3]):[0-5]\d)-(?P<closes>(?:[01]\d|2[0-3]):[0-5]\d|24:00)$"
)
_DAY_MINUTES: Final = 24 * 60
_LOOK_AHEAD_DAYS: Final = 9
"""A week, and the days whose windows reach into it."""
_WEEK: Final = timedelta(days=7, hours=-2)
"""From the first opening to before the same one a week later, even if clocks change."""


def zone_of(name: str) -> tzinfo:
    """Return a time zone by its IANA name; UTC needs no data. Raises `ZoneInfoNotFoundError`."""
    return UTC if name == "UTC" else ZoneInfo(name)


@dataclass(frozen=True, slots=True)
class Window:
    """Open on `days` (0 is Monday) from `opens` to `closes`, in minutes after midnight."""

    days: frozenset[int]
    opens: int
    closes: int

    @property
    def closes_after(self) -> int:
        """When it closes, in minutes after the midnight before its opening."""
        return self.closes if self.closes > self.opens else self.closes + _DAY_MINUTES

    @classmethod
    def parse(cls, text: str) -> Self:
        """Read ``mon-fri 09:00-18:00``; raises `ValueError`."""
        found = re.match(PATTERN, text)
        if found is None:
            raise ValueError(f"{text!r} is not like 'mon-fri 09:00-18:00'")
        first = DAYS.index(found["first"])
        count = (DAYS.index(found["last"] or found["first"]) - first) % 7 + 1
        days = frozenset((first + day) % 7 for day in range(count))
        return cls(days, _minutes(found["opens"]), _minutes(found["closes"]))


@dataclass(frozen=True, slots=True)
class OpeningHours:
    """The weekly windows in a time zone; none at all means always open."""

    windows: tuple[Window, ...]
    zone: tzinfo

    @classmethod
    def of(cls, texts: Iterable[str], zone: tzinfo) -> Self:
        """Parse the hours; raises `ValueError`."""
        return cls(tuple(Window.parse(text) for text in texts), zone)

    def is_open(self, now: datetime) -> bool:
        """Whether it is open at `now`, which has a time zone."""
        return not self.windows or any(opens <= now < closes for opens, closes in self._near(now))

    def openings(self, now: datetime) -> list[tuple[datetime, datetime]]:
        """Return the openings and closings of the week after `now`; empty if always open.

        Windows that touch are merged.
        """
        found: list[tuple[datetime, datetime]] = []
        for opens, closes in sorted(one for one in self._near(now) if one[0] > now):
            if found and opens <= found[-1][1]:
                found[-1] = (found[-1][0], max(closes, found[-1][1]))
            elif not found or opens < found[0][0] + _WEEK:
                found.append((opens, closes))
        return found

    def opens_next(self, now: datetime) -> datetime | None:
        """Return when it opens after `now`; None if it is always open."""
        return next((opens for opens, _ in self.openings(now)), None)

    def on(self, day: date, window: Window) -> tuple[datetime, datetime] | None:
        """Return when a window opens and closes on a day, in UTC.

        None if clocks go forward over all of it.
        """
        opens = self.local(day, window.opens).astimezone(UTC)
        closes = self.local(day, window.closes_after).astimezone(UTC)
        return (opens, closes) if opens < closes else None

    def _near(self, now: datetime) -> Iterator[tuple[datetime, datetime]]:
        today = now.astimezone(self.zone).date()
        for ahead in range(-1, _LOOK_AHEAD_DAYS):
            day = today + timedelta(days=ahead)
            for window in self.windows:
                if day.weekday() in window.days and (span := self.on(day, window)) is not None:
                    yield span

    def local(self, day: date, minutes: int) -> datetime:
        """Return the local time so many minutes after the midnight of a day."""
        extra, minutes = divmod(minutes, _DAY_MINUTES)
        shown = time(minutes // 60, minutes % 60)
        return datetime.combine(day + timedelta(days=extra), shown, tzinfo=self.zone)


def _minutes(text: str) -> int:
    hours, minutes = text.split(":")
    return int(hours) * 60 + int(minutes)
