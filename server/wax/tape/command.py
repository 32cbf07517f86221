"""`wax tape`: lists, keeps, repairs and deletes parts, even while a server records."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import TYPE_CHECKING, Final

from wax.errors import ConfigError, StateError, reason_of
from wax.records.export import moment
from wax.tape.event_ending import ending_of
from wax.tape.repair import repair

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from wax.tape.shelf import Shelf, Shelved

_KEPT: Final = {None: "", "host": "kept", "operator": "kept by an operator", "fault": "a fault"}

_ENDS: Final = {
    "whole": "",
    "mended": "cut off, mended",
    "open": "being written",
    "cut": "cut off",
}
_HOW_TO_MEND: Final = (
    "What is cut off ends where the server was killed or lost its power. `wax tape repair` mends it"
    " so that other programs read it; so does the next start of a server that records."
)


def tape_list(shelf: Shelf) -> str:
    """Return a table of all parts, the oldest first; times are in UTC."""
    parts = shelf.parts()
    if not parts:
        return f"Nothing is recorded in {shelf.folder}."
    lines = [("name", "began", "length", "MB", "end", "why it is kept")]
    lines += [
        (
            one.name,
            f"{datetime.fromtimestamp(one.began_s, UTC):%Y-%m-%d %H:%M:%S}",
            f"{max(0.0, one.ended_s - one.began_s):.0f} s",
            f"{one.size_bytes / 1e6:.1f}",
            _end_of(one),
            _KEPT[one.kept],
        )
        for one in parts
    ]
    widths = [max(len(line[column]) for line in lines) for column in range(len(lines[0]))]
    table = [
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in lines
    ]
    how = [_HOW_TO_MEND] if any(line[4] == _ENDS["cut"] for line in lines) else []
    return "\n".join([*table, f"{_counted(parts)} in {shelf.folder}", *how])


def tape_repair(shelf: Shelf) -> str:
    """Repair the parts that were cut off; raises `StateError` for those that cannot be repaired."""
    mended = repair(shelf)
    if mended.problems:
        raise StateError("\n".join(mended.problems))
    if not mended.parts:
        return f"Nothing that is finished is cut off in {shelf.folder}."
    return "\n".join(f"Mended: {name}" for name in mended.parts)


def tape_keep(shelf: Shelf, names: Sequence[str]) -> str:
    """Keep these parts until somebody deletes them; raises `StateError` for an unknown name."""
    parts = _named(shelf, names)
    _each(parts, lambda one: shelf.keep(one.name, "host"))
    return f"Kept: {_counted(parts)}."


def tape_delete(
    shelf: Shelf, names: Sequence[str], *, is_all: bool = False, before: str | None = None
) -> str:
    """Delete these parts, all, or all that ended before a time, whether kept or not.

    Raises `ConfigError` or `StateError` before anything is deleted, except when deleting fails.
    """
    if sum([bool(names), is_all, before is not None]) != 1:
        raise ConfigError("say what to delete: names from `wax tape list`, --all or --before DATE")
    if is_all:
        parts = shelf.parts()
    elif before is not None:
        until_s = moment(before, "--before").timestamp()
        parts = [one for one in shelf.parts() if one.ended_s < until_s]
    else:
        parts = _named(shelf, names)
    _each(parts, lambda one: shelf.delete(one.name))
    return f"Deleted: {_counted(parts)}."


def _end_of(part: Shelved) -> str:
    if part.events is None:
        return ""
    try:
        return _ENDS[ending_of(part.events)]
    except OSError as error:
        return reason_of(error)


def _named(shelf: Shelf, names: Sequence[str]) -> list[Shelved]:
    known = {one.name: one for one in shelf.parts()}
    for name in names:
        if name not in known:
            raise StateError(
                f"{shelf.folder}: there is no {name} in it; `wax tape list` shows what there is"
            )
    return [known[name] for name in dict.fromkeys(names)]


def _each(parts: Sequence[Shelved], do: Callable[[Shelved], None]) -> None:
    for one in parts:
        try:
            do(one)
        except OSError as error:
            raise StateError(f"{one.name}: {reason_of(error)}") from error


def _counted(parts: Sequence[Shelved]) -> str:
    size = sum(one.size_bytes for one in parts) / 1e6
    return f"{len(parts)} part{'' if len(parts) == 1 else 's'}, {size:.1f} MB"
