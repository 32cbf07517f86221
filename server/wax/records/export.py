"""`wax records`: a table for people, CSV or JSON for programs."""

from __future__ import annotations

import csv
import io
import json
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Final, Literal

from wax.errors import ConfigError
from wax.records.reading import read
from wax.records.schema import EXPORTED

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from wax.records.reading import Row, Table
    from wax.records.writer import Value

Format = Literal["table", "csv", "json"]

_SHOWN: Final = {
    "sessions": (
        *("began", "ended", "name", "address", "role", "round_trip_ms", "lost_percent"),
        *("picture_age_ms", "sound_age_ms", "rendition"),
    ),
    "turns": ("began", "ended", "number", "name", "why"),
    "stops": ("began", "ended", "name", "reason", "released_by"),
    "acts": ("began", "name", "act", "about", "detail"),
    "refusals": ("began", "reason", "count"),
}
"""The columns of the printed table; CSV and JSON have all columns."""
_NEWEST: Final = 50
"""The most rows of a printed table without `--since`."""
_MAX_WIDTH: Final = 60
_FORMULA: Final = ("=", "+", "-", "@", "\t", "\r")


def export(path: Path, table: str | None, since: str | None, format_: Format) -> str:
    """Return a table, or all of them for None, as text; times are ISO 8601 in UTC.

    Raises `ConfigError` for wrong usage, `StateError` if the file cannot be read.
    """
    if format_ == "csv" and table is None:
        raise ConfigError(f"--csv: say which table; there are {', '.join(EXPORTED)}")
    after = None if since is None else moment(since, "--since")
    found = {one: read(path, one, after) for one in ([table] if table else EXPORTED)}
    if format_ == "json":
        rows = {name: one.rows for name, one in found.items()}
        return json.dumps(rows[table] if table else rows, ensure_ascii=False, indent=1)
    if format_ == "csv":
        return "\n".join(map(_csv, found.values()))
    newest = None if after else _NEWEST
    return "\n\n".join(_table(name, one.rows, newest) for name, one in found.items())


def moment(text: str, option: str) -> datetime:
    """Parse a date with or without a time, in UTC unless it has an offset."""
    try:
        found = datetime.fromisoformat(text)
    except ValueError as error:
        raise ConfigError(
            f"{option}: got {text!r}; allowed is a date as 2026-11-01, or with a time as"
            " 2026-11-01T18:30"
        ) from error
    return found.replace(tzinfo=UTC) if found.tzinfo is None else found


def _csv(table: Table) -> str:
    text = io.StringIO()
    writer = csv.DictWriter(text, table.columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows({name: _safe(value) for name, value in row.items()} for row in table.rows)
    return text.getvalue().rstrip("\n")


def _safe(value: Value) -> Value:
    """Escape text that a spreadsheet would run as a formula (OWASP, CSV injection)."""
    return f"'{value}" if isinstance(value, str) and value.startswith(_FORMULA) else value


def _table(name: str, rows: Sequence[Row], newest: int | None) -> str:
    if not rows:
        return f"No {name}."
    columns = _SHOWN[name]
    shown = rows if newest is None else rows[-newest:]
    lines = [[one.replace("_", " ") for one in columns]]
    lines += [[_cell(row[one]) for one in columns] for row in shown]
    widths = [max(len(line[number]) for line in lines) for number in range(len(columns))]
    text = [f"{len(rows)} {name if len(rows) > 1 else name[:-1]}:"]
    for line in lines:
        cells = (cell.ljust(width) for cell, width in zip(line, widths, strict=True))
        text.append("  " + "  ".join(cells).rstrip())
    if len(shown) < len(rows):
        text.append(f"  … and {len(rows) - len(shown)} older; --since DATE shows them")
    return "\n".join(text)


def _cell(value: Value) -> str:
    if value is None:
        return "–"
    if isinstance(value, float):
        return f"{value:g}"
    text = str(value)
    return text if len(text) <= _MAX_WIDTH else text[: _MAX_WIDTH - 1] + "…"
