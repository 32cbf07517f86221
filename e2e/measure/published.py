"""One small JSON file per suite, the source of the tables."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Final

from pydantic import BaseModel, ConfigDict, ValidationError

from e2e.measure.errors import MeasureError
from e2e.measure.row import Row
from e2e.measure.suite import ROOT, digest
from wax import __version__

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from e2e.measure.results import Result
    from e2e.measure.suite import Suite

FOLDER: Final = ROOT / "e2e/published"
_DIGITS: Final = 4


class Published(BaseModel):
    """The rows of a suite, all measured at one commit of one version.

    `load` is the highest 1-minute load average before a case; `measured` is the hash of the files
    that `measures` matched.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    suite: str
    about: str = ""
    version: str = ""
    commit: str
    date: str
    machine: str
    load: float | None
    measures: list[str]
    measured: str
    columns: list[str]
    rows: list[Row]
    notes: list[str] = []

    def to_json(self) -> str:
        return self.model_dump_json(indent=1, exclude_defaults=True) + "\n"

    @property
    def is_changed(self) -> bool:
        """Whether the measured files have changed since."""
        return self.measured != digest(self.measures)


def load(path: Path) -> Published:
    """Read one; raises `MeasureError`."""
    try:
        return Published.model_validate_json(path.read_bytes())
    except (OSError, ValidationError) as error:
        raise MeasureError(f"{path} cannot be read: {error}") from error


def everything(folder: Path = FOLDER) -> list[Published]:
    return [load(path) for path in sorted(folder.glob("*.json"))]


def publish(suite: Suite, results: Sequence[Result], folder: Path = FOLDER) -> Path:
    """Write the results of all cases, of one origin and in order."""
    rows = suite.derive([row for result in results for row in result.rows])
    origin = results[0].origin
    published = Published(
        suite=suite.name,
        about=suite.about,
        version=__version__,
        commit=origin.commit,
        date=max(result.started_utc for result in results)[:10],
        machine=str(origin.machine),
        load=round(max(result.load_1min for result in results), 2),
        measures=list(suite.measures),
        measured=origin.measured,
        columns=list(suite.columns),
        rows=[_small(row) for row in rows],
        notes=list(suite.notes),
    )
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{suite.name}.json"
    path.write_text(published.to_json(), encoding="utf-8")
    return path


def _small(row: Row) -> Row:
    """Round the values, and drop what matters only during the run."""
    text = row.model_copy(update={"detail": {}}).model_dump_json()
    return Row.model_validate(
        json.loads(text, parse_float=lambda value: round(float(value), _DIGITS))
    )
