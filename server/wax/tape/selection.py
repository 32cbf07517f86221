"""Chooses the parts that an export reads, by time and by whether they are kept."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from wax.errors import ConfigError, StateError
from wax.records.export import moment

if TYPE_CHECKING:
    from wax.tape.shelf import Shelf, Shelved


@dataclass(frozen=True, slots=True)
class Selection:
    """The parts to read, the oldest first; both times are in seconds since 1970.

    The first and the last of them may reach beyond these times.
    """

    parts: list[Shelved]
    begin_s: float = -math.inf
    end_s: float = math.inf


def select(
    shelf: Shelf, *, begin: str | None = None, end: str | None = None, kept: bool = False
) -> Selection:
    """Select the parts that reach into the time from `begin` to `end`, perhaps only kept ones.

    Raises `ConfigError` for what is no date, `StateError` if there is no such part.
    """
    begin_s = -math.inf if begin is None else moment(begin, "--from").timestamp()
    end_s = math.inf if end is None else moment(end, "--to").timestamp()
    if begin_s >= end_s:
        raise ConfigError("--from must be earlier than --to")
    parts = [
        one
        for one in shelf.parts()
        if one.ended_s >= begin_s and one.began_s < end_s and (one.kept or not kept)
    ]
    if not parts:
        which = "kept" if kept else "recorded"
        when = "" if begin is None and end is None else " at that time"
        raise StateError(
            f"{shelf.folder}: nothing is {which}{when}; `wax tape list` shows what there is"
        )
    return Selection(parts, begin_s, end_s)
