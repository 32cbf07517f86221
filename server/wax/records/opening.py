"""Opens the records before the event loop starts."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from typing import TYPE_CHECKING, Final

import structlog

from wax import state_dir
from wax.errors import StateError
from wax.named_file import check
from wax.records import file as record_file
from wax.records import schema
from wax.records.entries import Ban, HostCookie, Invited, Lasting
from wax.records.records import Records
from wax.records.writer import RecordWriter

if TYPE_CHECKING:
    from pathlib import Path

    from wax.clock import Clock
    from wax.config.records import RecordSettings

_LOG = structlog.get_logger(__name__)

FILE: Final = "records.db"


def open_records(settings: RecordSettings, state: str, clock: Clock) -> Records:
    """Open the records; if they cannot be written, warn and only load what is in force.

    `state` is the configured state folder.
    """
    if not settings.enabled:
        return Records(clock)
    path = None
    try:
        path = where(settings, state)
        state_dir.prepare(path.parent)
    except StateError as error:
        _LOG.warning("nothing is recorded", error=str(error))
        return Records(clock, Lasting() if path is None else load_lasting(path, clock))
    writer = RecordWriter(path, keep_days=settings.keep_days, clock=clock)
    return Records(clock, load_lasting(path, clock), writer)


def where(settings: RecordSettings, state: str) -> Path:
    """Return the path of the file; raises `StateError`."""
    if settings.path:
        return state_dir.find(settings.path)
    return state_dir.find(state) / FILE


def load_lasting(path: Path, clock: Clock) -> Lasting:
    """Return the entries still in force; warn and return none if the file is unreadable."""
    try:
        return _load(path, clock)
    except (sqlite3.Error, OSError, schema.NotOursError) as error:
        _LOG.warning(
            "bans, invitations and hosts are not known: the records cannot be read",
            file=str(path),
            error=str(error),
        )
        return Lasting()


def _load(path: Path, clock: Clock) -> Lasting:
    try:
        with closing(record_file.open_for_writing(path)):
            rows = record_file.read_lasting(path)
    except (sqlite3.Error, OSError) as error:
        is_damaged = record_file.is_damage(error)
        if is_damaged:
            record_file.move_aside(path, clock.wall_ms())
        check(path)
        rows = record_file.read_lasting(path, is_ours=is_damaged)
    return Lasting(
        bans=tuple(Ban(who, where, ms / 1000) for who, where, ms in rows["bans"]),
        invited=tuple(Invited(one, who, why, ms / 1000) for one, who, why, ms in rows["invited"]),
        host_cookies=tuple(HostCookie(one, ms / 1000) for one, ms in rows["host_cookies"]),
    )
