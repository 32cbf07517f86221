"""What stands above the tables: what this is, where and how it was measured, what is missing."""

from __future__ import annotations

import shlex
from collections import Counter
from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING, Any, Final

from e2e.lab.report.blocks import Finding
from e2e.lab.report.emulator import Emulator, emulator
from e2e.lab.report.names import SYSTEMS

if TYPE_CHECKING:
    from e2e.lab.report.pick import Entries
    from e2e.lab.results import Run

UNITS: Final = ("_ms", "_s", "_mib", "_bps", "_share", "_utc")


@dataclass(frozen=True, slots=True)
class Missing:
    """Cells that failed or were not run for one and the same reason."""

    text: str
    entries: Entries


@dataclass(frozen=True, slots=True)
class Head:
    when: str
    took: str
    again: str
    machine: tuple[tuple[str, str], ...]
    instrument: tuple[tuple[str, str], ...]
    emulator: Emulator | None
    missing: tuple[Missing, ...]
    counted: Finding


def head(run: Run, cells: Entries) -> Head:
    return Head(
        when=_when(run.started_utc),
        took=_took(run.took_s),
        again=_again(run.arguments),
        machine=tuple(_facts(run.machine)),
        instrument=tuple(_facts(run.instrument)),
        emulator=emulator(run),
        missing=_missing(cells),
        counted=_counted(cells),
    )


def _again(arguments: list[str]) -> str:
    """Say how to measure the same again, wherever that is then put."""
    if "--out" in arguments:
        place = arguments.index("--out")
        arguments = arguments[:place] + arguments[place + 2 :]
    arguments = [one for one in arguments if not one.startswith("--out=")]
    return f"make lab ARGS={shlex.quote(shlex.join(arguments))}" if arguments else "make lab"


def _when(started_utc: str) -> str:
    try:
        return datetime.fromisoformat(started_utc).strftime("%-d %B %Y, %H:%M UTC")
    except ValueError:
        return started_utc


def _took(seconds: float) -> str:
    if not 0 <= seconds < 1e9:
        return "an unknown time"
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    parts = ((hours, "h"), (minutes, "min"), (rest if not hours else 0, "s"))
    return " ".join(f"{number} {unit}" for number, unit in parts if number) or "no time"


def _counted(cells: Entries) -> Finding:
    counts = Counter(entry.result.status for entry in cells)
    variants = len({entry.cell.variant for entry in cells})
    text = (
        f"{counts['ok']} of {len(cells)} cells were measured, {counts['failed']} failed, "
        f"{counts['not run']} were not run; {variants} are different ones, the rest repetitions."
    )
    return Finding(text if cells else "This run has no cells: nothing was measured.")


def _missing(cells: Entries) -> tuple[Missing, ...]:
    found: dict[tuple[str, str, str], list[Any]] = {}
    for entry in cells:
        if entry.result.status != "ok":
            key = (entry.cell.system, entry.result.status, entry.problem)
            found.setdefault(key, []).append(entry)
    return tuple(
        Missing(
            f"{next(label for name, label in SYSTEMS.items() if name == system)}, "
            f"{len(entries)} cell{'s' if len(entries) > 1 else ''} {status}: {problem}",
            tuple(entries),
        )
        for (system, status, problem), entries in found.items()
    )


def _facts(tree: dict[str, Any]) -> list[tuple[str, str]]:
    """Lay a tree of JSON out as pairs of words; what is nested keeps its parents' names."""
    found: list[tuple[str, str]] = []
    for key, value in tree.items():
        words = _words(str(key))
        if (
            isinstance(value, dict)
            and value
            and all(isinstance(one, str) for one in value.values())
        ):
            found.append((words, ", ".join(f"{name} {one}" for name, one in value.items())))
        elif isinstance(value, dict):
            found += [(f"{words}: {name}", text) for name, text in _facts(value)]
        else:
            found.append((words, _text(value)))
    return found


def _words(key: str) -> str:
    for unit in UNITS:
        if key.endswith(unit):
            return f"{key.removesuffix(unit).replace('_', ' ')}, {unit[1:].replace('mib', 'MiB')}"
    return key.replace("_", " ")


def _text(value: Any) -> str:
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"
    if isinstance(value, list | tuple):
        return ", ".join(_text(one) for one in value) or "–"
    return str(value)
