"""The tables. Times are milliseconds since 1970 (UTC), NULL if still in the future.

A change adds an entry to `STEPS`, which upgrades older files; entries are never edited.
"""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    import sqlite3
    from collections.abc import Iterator

APPLICATION: Final = 0x5741_5801
"""Identifies the file as ours (SQLite, PRAGMA application_id)."""

_FIRST: Final = """
CREATE TABLE sessions (
    id INTEGER PRIMARY KEY,
    began_ms INTEGER NOT NULL,
    seen_ms INTEGER NOT NULL,       -- the newest news of it
    ended_ms INTEGER,
    person TEXT NOT NULL,           -- a hash, the same for all visits of one browser
    name TEXT NOT NULL,
    address TEXT NOT NULL,          -- a network, not a person's own
    role TEXT NOT NULL,
    round_trip_ms REAL,             -- medians, and the worst
    round_trip_worst_ms REAL,
    picture_age_ms REAL,
    picture_age_worst_ms REAL,
    sound_age_ms REAL,
    sound_age_worst_ms REAL,
    lost_percent REAL,
    lost_worst_percent REAL,
    rendition TEXT                  -- the one they had longest
);
CREATE INDEX sessions_by_time ON sessions (began_ms);
CREATE TABLE turns (
    id INTEGER PRIMARY KEY,
    began_ms INTEGER NOT NULL,
    ended_ms INTEGER,
    number INTEGER NOT NULL,        -- begins anew with each server
    person TEXT NOT NULL,
    name TEXT NOT NULL,
    why TEXT                        -- why it ended
);
CREATE INDEX turns_by_time ON turns (began_ms);
CREATE TABLE stops (
    id INTEGER PRIMARY KEY,
    began_ms INTEGER NOT NULL,
    ended_ms INTEGER,               -- when it was released
    number INTEGER,                 -- NULL where nobody pressed it
    person TEXT NOT NULL,           -- who pressed it, or drove when the robot stopped
    name TEXT NOT NULL,
    reason TEXT NOT NULL,
    released_by TEXT
);
CREATE INDEX stops_by_time ON stops (began_ms);
CREATE TABLE acts (
    id INTEGER PRIMARY KEY,
    began_ms INTEGER NOT NULL,
    person TEXT NOT NULL,           -- the host
    name TEXT NOT NULL,
    act TEXT NOT NULL,
    about TEXT NOT NULL,            -- whom or what
    detail TEXT NOT NULL
);
CREATE INDEX acts_by_time ON acts (began_ms);
CREATE TABLE refusals (
    began_ms INTEGER NOT NULL,      -- the hour
    reason TEXT NOT NULL,
    count INTEGER NOT NULL,
    PRIMARY KEY (began_ms, reason)
) WITHOUT ROWID;
CREATE TABLE bans (
    identity TEXT NOT NULL,
    address TEXT NOT NULL,
    until_ms INTEGER NOT NULL,
    PRIMARY KEY (identity, address)
) WITHOUT ROWID;
CREATE TABLE invited (
    invitation TEXT NOT NULL,
    identity TEXT NOT NULL,         -- one use of the invitation
    purpose TEXT NOT NULL,
    until_ms INTEGER NOT NULL,
    PRIMARY KEY (invitation, identity)
) WITHOUT ROWID;
CREATE TABLE host_cookies (
    hash TEXT PRIMARY KEY,
    until_ms INTEGER NOT NULL
) WITHOUT ROWID;
"""

STEPS: Final = (_FIRST,)
"""The statements that upgrade each version, starting at 0, to the next."""
VERSION: Final = len(STEPS)

EXPORTED: Final = ("sessions", "turns", "stops", "acts", "refusals")
"""The tables that `wax records` shows; rows are kept for the configured days."""
LASTING: Final = ("bans", "invited", "host_cookies")
"""The tables that the server reads when it starts; rows are kept while in force."""

MAX_ROWS: Final = 500_000
"""The most rows of one table, a hundred megabytes, because strangers can cause new rows."""


class NotOursError(Exception):
    """An intact file of another program or of a newer WAX, which must not be changed."""


def upgrade(file: sqlite3.Connection) -> None:
    """Create or upgrade the tables; raises `NotOursError` or `sqlite3.Error`."""
    if check(file) == VERSION:
        return
    with transaction(file):
        for number in range(check(file), VERSION):  # again: another server may be first
            for statement in STEPS[number].split(";"):
                file.execute(statement)
            file.execute(f"PRAGMA user_version={number + 1}")
        file.execute(f"PRAGMA application_id={APPLICATION}")


def check(file: sqlite3.Connection) -> int:
    """Return the version of a file of ours, 0 for an empty one.

    Raises `NotOursError` for any other database, or `sqlite3.Error`.
    """
    (application,) = file.execute("PRAGMA application_id").fetchone()
    (version,) = file.execute("PRAGMA user_version").fetchone()
    (tables,) = file.execute("SELECT count(*) FROM sqlite_master").fetchone()
    if application != APPLICATION and (application or version or tables):
        raise NotOursError("is a database of another program")
    if version > VERSION:
        raise NotOursError("was written by a newer version of WAX")
    return int(version)


@contextmanager
def transaction(file: sqlite3.Connection) -> Iterator[None]:
    """Write all of the block or nothing; raises `sqlite3.Error`."""
    file.execute("BEGIN IMMEDIATE")
    with file:  # commits or rolls back
        yield


def prune(file: sqlite3.Connection, *, now_ms: int, keep_ms: int, max_rows: int = MAX_ROWS) -> None:
    """Delete expired and old rows, and the oldest beyond `max_rows`; raises `sqlite3.Error`."""
    with transaction(file):
        for table in EXPORTED:
            file.execute(f"DELETE FROM {table} WHERE began_ms < ?", (now_ms - keep_ms,))
            file.execute(
                f"DELETE FROM {table} WHERE began_ms <="
                f" (SELECT began_ms FROM {table} ORDER BY began_ms DESC LIMIT 1 OFFSET ?)",
                (max_rows,),
            )
        for table in LASTING:
            file.execute(f"DELETE FROM {table} WHERE until_ms < ?", (now_ms,))
    file.execute("PRAGMA incremental_vacuum")
