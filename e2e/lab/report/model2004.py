"""The rows of the model of 2004's client, as a run keeps them in `Run.client2004`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, ValidationError

from e2e.lab.client2004 import table
from e2e.lab.client2004.scenes import SCENES

if TYPE_CHECKING:
    from e2e.lab.results import Run


class ModelRow(BaseModel):
    """What the model hears of one connection with one audio MU."""

    scene: str
    """As `e2e.lab.client2004.scenes` names it."""
    mu_ms: int
    pauses_per_s: float
    longest_ms: float
    silence: float
    """The share of the time that was pause."""

    @property
    def is_clean(self) -> bool:
        return self.pauses_per_s < table.CLEAN_PER_S


def rows() -> list[dict[str, Any]]:
    """Run the model over all its connections; some seconds."""
    found: list[dict[str, Any]] = []
    for scene in SCENES:
        for mu_ms in table.MU_LENGTHS_MS:
            heard = table.hear(scene, mu_ms)
            row = ModelRow(
                scene=scene.name,
                mu_ms=mu_ms,
                pauses_per_s=heard.pauses_per_s,
                longest_ms=heard.longest_ms,
                silence=heard.silence,
            )
            found.append(row.model_dump())
    return found


def of(run: Run) -> dict[tuple[str, int], ModelRow]:
    """Find the rows of a run by scene and MU; what is no such row is left out."""
    found: dict[tuple[str, int], ModelRow] = {}
    for given in run.client2004:
        try:
            row = ModelRow.model_validate(given)
        except ValidationError:
            continue
        found[row.scene, row.mu_ms] = row
    return found
