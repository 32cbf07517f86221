"""One number of a cell: its name, its unit, and how a person writes it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

if TYPE_CHECKING:
    from collections.abc import Callable

    from e2e.lab.figures import Figures
    from e2e.lab.readings import Readings
    from e2e.lab.results import CellResult

Unit = Literal[
    "ms", "signed ms", "per s", "per min", "s", "share", "bytes/s", "signed ms/min", "MiB", "1"
]
UNITS: Final[dict[Unit, str]] = {
    "ms": "ms",
    "signed ms": "ms",
    "per s": "per s",
    "per min": "per min",
    "s": "s",
    "share": "%",
    "bytes/s": "kB/s",
    "signed ms/min": "ms/min",
    "MiB": "MiB",
    "1": "",
}


@dataclass(frozen=True, slots=True)
class Measure:
    """One number of a cell; `get` gives None where there is nothing measured."""

    name: str
    label: str
    unit: Unit
    get: Callable[[CellResult], float | None]
    about: str = ""

    def of(self, result: CellResult) -> float | None:
        """Give the number, None unless the cell is ok and the number finite."""
        value = self.get(result) if result.status == "ok" else None
        return value if value is not None and math.isfinite(value) else None

    def text(self, value: float) -> str:
        """Write it without its unit: three figures, a true minus, a plus where the sign tells."""
        shown = value * 100 if self.unit == "share" else value
        shown = shown / 1000 if self.unit == "bytes/s" else shown
        size = abs(shown)
        if size >= 1e9:
            return f"{shown:.3g}"
        digits = 0 if size >= 100 or ("ms" in self.unit and size >= 10) else 1
        if size and size < 1:
            digits = 2
        text = f"{shown:+.{digits}f}" if self.unit.startswith("signed") else ""
        text = text or f"{shown:.{digits}f}"
        if "." in text:
            text = text.rstrip("0").rstrip(".")
        return "0" if text.strip("+-0.") == "" else text.replace("-", "−")

    def with_unit(self, value: float) -> str:
        return f"{self.text(value)} {UNITS[self.unit]}".rstrip()


def from_readings(
    get: Callable[[Readings, Figures], float | None],
) -> Callable[[CellResult], float | None]:
    """Make a `Measure.get` of what needs the raw series; None where there are none."""
    return lambda result: (
        None
        if result.figures is None or result.readings is None
        else get(result.readings, result.figures)
    )
