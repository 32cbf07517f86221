"""Opens the records' file for writing or reading, and replaces a damaged one."""

from __future__ import annotations

import sqlite3
from contextlib import closing, suppress
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any, Final

import structlog

from wax import state_dir
from wax.records import schema

if TYPE_CHECKING:
    from pathlib import Path

_LOG = structlog.get_logger(__name__)

BUSY_S: Final = 2.0
"""How long to wait for another program that has locked the file."""
_MAX_WAL_BYTES: Final = 4_000_000
_DAMAGED: Final = (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB)

Rows = dict[str, list[tuple[Any, ...]]]
"""Rows by table."""


def open_for_writing(path: Path) -> sqlite3.Connection:
    """Open the file; create or upgrade it if necessary.

    Raises `sqlite3.Error`, `OSError` or `schema.NotOursError`.
    """
    state_dir.make_private(path)
    file = sqlite3.connect(path, timeout=BUSY_S, isolation_level=None)
    try:
        schema.check(file)  # before anything is changed
        file.execute("PRAGMA auto_vacuum=INCREMENTAL")
        file.execute("PRAGMA journal_mode=WAL")
        # Each commit survives a power cut; the writer commits at most four times a second, and not
        # while nothing happens.
        file.execute("PRAGMA synchronous=FULL")
        file.execute(f"PRAGMA journal_size_limit={_MAX_WAL_BYTES}")
        schema.upgrade(file)
    except BaseException:
        file.close()
        raise
    return file


def open_for_reading(path: Path, *, is_ours: bool = True) -> sqlite3.Connection:
    """Open a file that a server may be writing; raises `sqlite3.Error`.

    A file that we may not write is opened as immutable unless its whole log exists, because SQLite
    would otherwise create the log's files next to it.
    """
    has_log = all(path.with_name(path.name + ending).exists() for ending in ("-wal", "-shm"))
    how = "mode=ro" if is_ours or has_log else "mode=ro&immutable=1"
    return sqlite3.connect(f"{path.resolve().as_uri()}?{how}", uri=True, timeout=BUSY_S)


def is_damage(error: Exception) -> bool:
    """Return whether the error means a damaged database, so that a retry cannot help."""
    return isinstance(error, sqlite3.Error) and getattr(error, "sqlite_errorcode", 0) in _DAMAGED


def move_aside(path: Path, now_ms: int) -> None:
    """Rename a damaged file and start a new one with the readable rows of the lasting tables.

    Raises `sqlite3.Error` or `OSError`.
    """
    lasting = _salvaged(path)
    when = datetime.fromtimestamp(now_ms / 1000, UTC)
    aside = path.with_name(f"{path.name}.damaged-{when:%Y%m%dT%H%M%S}")
    for ending in ("", "-wal", "-shm"):
        with suppress(FileNotFoundError):
            path.with_name(path.name + ending).rename(aside.with_name(aside.name + ending))
    _LOG.warning(
        "the records were damaged; they are set aside, and new ones begin", file=str(aside)
    )
    with closing(open_for_writing(path)) as file, schema.transaction(file):
        for table, rows in lasting.items():
            for row in rows:
                marks = ", ".join("?" * len(row))
                file.execute(f"INSERT OR REPLACE INTO {table} VALUES ({marks})", row)


def read_lasting(path: Path, *, is_ours: bool = True) -> Rows:
    """Return the lasting tables' rows; raises `sqlite3.Error` or `schema.NotOursError`."""
    with closing(open_for_reading(path, is_ours=is_ours)) as file:
        schema.check(file)
        return {
            table: file.execute(f"SELECT * FROM {table}").fetchall() for table in schema.LASTING
        }


def _salvaged(path: Path) -> Rows:
    found: Rows = {}
    with suppress(sqlite3.Error), closing(open_for_reading(path)) as file:
        for table in schema.LASTING:
            with suppress(sqlite3.Error):
                # Read one by one: rows before the damage are readable.
                for row in file.execute(f"SELECT * FROM {table}"):
                    found.setdefault(table, []).append(row)
    return found
