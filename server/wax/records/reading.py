"""Reads the records as tables of text, while a server may be writing them."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any, Final

from wax.errors import StateError, reason_of
from wax.named_file import check
from wax.records import file as record_file
from wax.records import schema

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from wax.records.writer import Value

_TIMES: Final = ("began_ms", "seen_ms", "ended_ms")
_DAMAGED: Final = "is damaged; the server sets it aside at its next start and begins a new one"
_LOCKED: Final = "is locked by another program; close that, or try again"

Row = dict[str, "Value"]


@dataclass(frozen=True, slots=True)
class Table:
    """The rows of a table, the oldest first, each with all columns."""

    columns: Sequence[str]
    rows: Sequence[Row]


def read(path: Path, table: str, since: datetime | None) -> Table:
    """Return a table's rows from `since` on; times are ISO 8601 in UTC.

    Raises `StateError` with what to do.
    """
    try:
        check(path)  # SQLite would block on a pipe
        with closing(record_file.open_for_reading(path)) as file:
            if not schema.check(file):
                raise StateError(f"{path}: there are no records in it")
            return _rows(file, table, since)
    except schema.NotOursError as error:
        raise StateError(f"{path}: {error}") from error
    except FileNotFoundError:
        raise StateError(
            f"{path}: there are no records; no server has run with this configuration and user"
        ) from None
    except OSError as error:
        raise StateError(_cannot(path, reason_of(error))) from error
    except sqlite3.Error as error:
        if record_file.is_damage(error):
            raise StateError(f"{path}: {_DAMAGED}") from error
        if getattr(error, "sqlite_errorcode", 0) & 0xFF in (
            sqlite3.SQLITE_BUSY,
            sqlite3.SQLITE_LOCKED,
        ):
            raise StateError(f"{path}: {_LOCKED}") from error
        raise StateError(_cannot(path, str(error))) from error


def _rows(file: sqlite3.Connection, table: str, since: datetime | None) -> Table:
    since_ms = 0 if since is None else int(since.timestamp() * 1000)
    found = file.execute(
        f"SELECT * FROM {table} WHERE began_ms >= ? ORDER BY began_ms", (since_ms,)
    )
    names = [column[0] for column in found.description]
    rows = [_readable(dict(zip(names, row, strict=True))) for row in found]
    return Table(list(_readable(dict.fromkeys(names))), rows)


def _readable(row: dict[str, Any]) -> Row:
    """Return a row without its id, with its times in ISO 8601."""
    return {
        name.removesuffix("_ms") if name in _TIMES else name: _iso(value)
        if name in _TIMES
        else value
        for name, value in row.items()
        if name != "id"
    }


def _iso(time_ms: int | None) -> str | None:
    if time_ms is None:
        return None
    try:
        time = datetime.fromtimestamp(time_ms / 1000, UTC)
    except (ValueError, OverflowError, OSError):  # the file has an impossible year
        return None
    return time.isoformat(timespec="milliseconds").replace("+00:00", "Z")


def _cannot(path: Path, why: str) -> str:
    return f"{path}: cannot be read: {why}; run this as the server's user"
