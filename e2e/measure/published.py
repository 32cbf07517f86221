"""One small JSON file per suite, the source of the tables."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from pydantic import BaseModel, ConfigDict, ValidationError

from e2e.measure.errors import MeasureError
from e2e.measure.row import Row
from e2e.measure.suite import ROOT, digest

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from e2e.measure.results import Result
    from e2e.measure.suite import Suite

FOLDER: Final = ROOT / "e2e/published"
_DIGITS: Final = 4


class Published(BaseModel):
    """The rows of one run of the same product.

    `commit` names more than one where a case was measured again after a change to what measures.
    `load` is the highest 1-minute load average before a case. `measured` is the hash over what
    `measures` matched; None where the figures come from `source` and not from a stored run.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    suite: str
    commit: str
    date: str
    machine: str
    load: float | None
    measures: list[str]
    measured: str | None
    source: str | None = None
    columns: list[str]
    rows: list[Row]
    notes: list[str] = []

    def to_json(self) -> str:
        return self.model_dump_json(indent=1, exclude_defaults=True) + "\n"

    @property
    def is_stale(self) -> bool:
        """Whether the measured files have changed since."""
        return self.measured is None or self.measured != digest(self.measures)


def load(suite: str, folder: Path = FOLDER) -> Published:
    """Read one; raises `MeasureError`."""
    path = folder / f"{suite}.json"
    try:
        return Published.model_validate_json(path.read_bytes())
    except (OSError, ValidationError) as error:
        raise MeasureError(f"{path} cannot be read: {error}") from error


def publish(suite: Suite, results: Sequence[Result], folder: Path = FOLDER) -> Path:
    """Write the results of all cases, of one product; raises `MeasureError` if one is missing."""
    by_case = {result.case: result for result in results if result.status == "ok"}
    keys = [case.key for case in suite.cases if not case.long]
    missing = [key for key in keys if key not in by_case]
    if missing:
        raise MeasureError(
            f"not published, for these cases have no result: {', '.join(missing)}; "
            "measure them with --resume --publish"
        )
    ordered = [by_case[key] for key in keys]
    origin = ordered[0].origin
    rows = suite.derive([row for result in ordered for row in result.rows])
    published = Published(
        suite=suite.name,
        commit=", ".join(dict.fromkeys(result.origin.commit for result in ordered)),
        date=ordered[-1].started_utc[:10],
        machine=str(origin.machine),
        load=round(max(result.load_1min for result in ordered), 2),
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
    """Round the values, and drop what is of interest only during the run."""
    spread = row.spread and row.spread.model_copy(
        update={name: round(value, _DIGITS) for name, value in row.spread if name != "n"}
    )
    values = {name: _rounded(value) for name, value in row.values.items()}
    goal = _rounded(row.goal)
    update = {"values": values, "spread": spread, "goal": goal, "detail": {}}
    return row.model_copy(update=update)


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, _DIGITS)
