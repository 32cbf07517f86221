"""When the robot is open to people, and when it opens next.

Hours are local times of the configured zone; a window that ends before it begins goes on past
midnight. Where a clock is put forward, a time that does not exist is the one an hour later.
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
_LOOK_AHEAD_DAYS: Final = 9
"""A week and the days that reach into it."""


def zone_of(name: str) -> tzinfo:
    """Return a time zone by its IANA name; UTC needs no data. Raises `ZoneInfoNotFoundError`."""
    return UTC if name == "UTC" else ZoneInfo(name)


@dataclass(frozen=True, slots=True)
class Window:
    """On the `days` (0 is Monday) open from `opens` to `closes`, minutes after midnight."""

    days: frozenset[int]
    opens: int
    closes: int

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
        """Whether it is open at a time (aware)."""
        return not self.windows or any(opens <= now < closes for opens, closes in self._near(now))

    def opens_next(self, now: datetime) -> datetime | None:
        """Return when it opens after `now`; None if it is always open."""
        return min((opens for opens, _ in self._near(now) if opens > now), default=None)

    def _near(self, now: datetime) -> Iterator[tuple[datetime, datetime]]:
        today = now.astimezone(self.zone).date()
        for ahead in range(-1, _LOOK_AHEAD_DAYS):
            day = today + timedelta(days=ahead)
            for window in self.windows:
                if day.weekday() in window.days:
                    over = window.closes <= window.opens
                    closes_on = day + timedelta(days=1) if over else day
                    opens, closes = self._at(day, window.opens), self._at(closes_on, window.closes)
                    if opens < closes:  # the clock may be put forward over all of it
                        yield opens, closes

    def _at(self, day: date, minutes: int) -> datetime:
        extra, minutes = divmod(minutes, 24 * 60)
        local = datetime.combine(
            day + timedelta(days=extra), time(minutes // 60, minutes % 60), tzinfo=self.zone
        )
        return local.astimezone(UTC)


def _minutes(text: str) -> int:
    hours, minutes = text.split(":")
    return int(hours) * 60 + int(minutes)
