"""Records what happens at the server; every call returns at once and never fails."""

from __future__ import annotations

import hashlib
import itertools
import secrets
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from wax.logs.printable import printable
from wax.records.entries import Lasting
from wax.records.shortened import shortened

if TYPE_CHECKING:
    from collections.abc import Mapping

    from wax.clock import Clock
    from wax.records.entries import Ban, Invited, LinkSummary, RecordedPerson
    from wax.records.writer import RecordWriter, Value

_MAX_CHARS: Final = 200
_HOUR_MS: Final = 3_600_000
_LAST_S: Final = 253_402_300_799.0
"""The end of the year 9999."""


@dataclass
class Records:
    """Call it from the event loop; without a writer every call works but stores nothing."""

    clock: Clock
    lasting: Lasting = field(default_factory=Lasting)
    writer: RecordWriter | None = None

    def __post_init__(self) -> None:
        # Ids are unique over all runs that share the file, without reading it. The time would not
        # do: a Raspberry Pi without a clock starts at the same time each time.
        self._ids = itertools.count(secrets.randbits(52))

    def start(self) -> None:
        if self.writer is not None:
            self.writer.start()
            self._enqueue("UPDATE sessions SET ended_ms = seen_ms WHERE ended_ms IS NULL")
            self._enqueue("UPDATE turns SET why = 'server killed' WHERE ended_ms IS NULL")

    def request_stop(self) -> None:
        if self.writer is not None:
            self.writer.request_stop()

    def stop(self, within_s: float = 1.0) -> None:
        """Write what is queued and end; give up after `within_s`."""
        if self.writer is not None:
            self.writer.stop(within_s)

    @property
    def waiting(self) -> int:
        """How many changes are not written yet."""
        return 0 if self.writer is None else self.writer.waiting

    @property
    def dropped(self) -> int:
        """How many changes were lost to a full disk, a locked file or the like."""
        return 0 if self.writer is None else self.writer.dropped

    # --- visits and turns --------------------------------------------------------------------

    def session_began(self, person: RecordedPerson, *, address: str, role: str) -> int:
        """Record the start of a visit with a shortened address; return its id."""
        now_ms, number = self.clock.wall_ms(), next(self._ids)
        self._enqueue(
            "INSERT INTO sessions (id, began_ms, seen_ms, person, name, address, role)"
            " VALUES (?, ?, ?, ?, ?, ?, ?)",
            *(number, now_ms, now_ms, _hashed(person.identity), person.name),
            *(shortened(address), role),
        )
        return number

    def session_seen(
        self,
        number: int,
        person: RecordedPerson,
        role: str,
        link: LinkSummary,
        *,
        is_over: bool = False,
    ) -> None:
        """Update a visit, or record its end."""
        now_ms = self.clock.wall_ms()
        self._enqueue(
            "UPDATE sessions SET seen_ms = ?, ended_ms = ?, name = ?, role = ?,"
            " round_trip_ms = ?, round_trip_worst_ms = ?,"
            " picture_age_ms = ?, picture_age_worst_ms = ?,"
            " sound_age_ms = ?, sound_age_worst_ms = ?,"
            " lost_percent = ?, lost_worst_percent = ?, rendition = ? WHERE id = ?",
            *(now_ms, now_ms if is_over else None, person.name, role),
            *(link.round_trip_ms, link.round_trip_worst_ms),
            *(link.picture_age_ms, link.picture_age_worst_ms),
            *(link.sound_age_ms, link.sound_age_worst_ms),
            *(link.lost_percent, link.lost_worst_percent, link.rendition, number),
        )

    def turn_began(self, turn: int, person: RecordedPerson) -> int:
        """Record the start of a turn; return its id."""
        number = next(self._ids)
        self._enqueue(
            "INSERT INTO turns (id, began_ms, number, person, name) VALUES (?, ?, ?, ?, ?)",
            *(number, self.clock.wall_ms(), turn, _hashed(person.identity), person.name),
        )
        return number

    def turn_ended(self, number: int, why: str) -> None:
        self._enqueue(
            "UPDATE turns SET ended_ms = ?, why = ? WHERE id = ?",
            *(self.clock.wall_ms(), why, number),
        )

    # --- stops, acts, refusals ---------------------------------------------------------------

    def stop_pressed(self, stop: int | None, person: RecordedPerson, reason: str) -> int:
        """Record a stop, `stop` None if nobody pressed it; return its id for the release."""
        number = next(self._ids)
        self._enqueue(
            "INSERT INTO stops (id, began_ms, number, person, name, reason)"
            " VALUES (?, ?, ?, ?, ?, ?)",
            *(number, self.clock.wall_ms(), stop, _hashed(person.identity), person.name, reason),
        )
        return number

    def stop_released(self, number: int, by: str) -> None:
        self._enqueue(
            "UPDATE stops SET ended_ms = ?, released_by = ? WHERE id = ?",
            *(self.clock.wall_ms(), by, number),
        )

    def host_act(
        self, host: RecordedPerson, act: str, *, about: str = "", detail: str = ""
    ) -> None:
        """Record a host's act, and to whom or what."""
        self._enqueue(
            "INSERT INTO acts (id, began_ms, person, name, act, about, detail)"
            " VALUES (?, ?, ?, ?, ?, ?, ?)",
            *(next(self._ids), self.clock.wall_ms(), _hashed(host.identity), host.name),
            *(act, about, detail),
        )

    def refused(self, counts: Mapping[str, int]) -> None:
        """Add to this hour's counts of refusals, by reason."""
        hour_ms = self.clock.wall_ms() // _HOUR_MS * _HOUR_MS
        for reason, count in counts.items():
            self._enqueue(
                "INSERT INTO refusals (began_ms, reason, count) VALUES (?, ?, ?)"
                " ON CONFLICT DO UPDATE SET count = count + excluded.count",
                *(hour_ms, reason, count),
            )

    # --- what must last ----------------------------------------------------------------------

    def keep_ban(self, ban: Ban) -> None:
        """Store a ban, or change its end."""
        self._enqueue_lasting(
            "INSERT OR REPLACE INTO bans (identity, address, until_ms) VALUES (?, ?, ?)",
            *(ban.identity, ban.address, _ms(ban.until_s)),
        )

    def keep_invited(self, invited: Invited) -> None:
        """Store the use of an invitation; a second use by the same person changes nothing."""
        self._enqueue_lasting(
            "INSERT OR REPLACE INTO invited (invitation, identity, purpose, until_ms)"
            " VALUES (?, ?, ?, ?)",
            *(invited.invitation, invited.identity, invited.purpose, _ms(invited.until_s)),
        )

    def keep_host_cookie(self, hashed: str, until_s: float) -> None:
        """Store a cookie's hash, or change its end."""
        self._enqueue_lasting(
            "INSERT OR REPLACE INTO host_cookies (hash, until_ms) VALUES (?, ?)",
            *(hashed, _ms(until_s)),
        )

    def _enqueue(self, sql: str, *values: Value) -> None:
        if self.writer is not None:
            self.writer.put(sql, *map(_bounded, values))

    def _enqueue_lasting(self, sql: str, *values: Value) -> None:
        # Values are not shortened, because they are compared later; callers have checked them.
        if self.writer is not None:
            self.writer.put(sql, *values, lasting=True)


def _bounded(value: Value) -> Value:
    return printable(value, _MAX_CHARS) if isinstance(value, str) else value


def _hashed(identity: str) -> str:
    """Return a hash that identifies a person in the records, but cannot be used to log in."""
    return identity and hashlib.sha256(identity.encode(errors="replace")).hexdigest()[:12]


def _ms(time_s: float) -> int:
    return int(min(max(time_s, 0.0), _LAST_S) * 1000)
