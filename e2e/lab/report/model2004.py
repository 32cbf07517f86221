"""The rows of the model of 2004's client, as a run keeps them in `Run.client2004`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from pydantic import BaseModel, ValidationError

from e2e.lab.client2004 import table
from e2e.lab.client2004.scenes import SCENES
from e2e.lab.client2004.thesis import SAID

if TYPE_CHECKING:
    from e2e.lab.results import Run

FAR: Final = 2.0
"""Longest pauses that are more than so many times apart are told."""


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

    @property
    def words(self) -> str:
        if self.is_clean:
            return "none"
        return f"{self.pauses_per_s:.1f} per s, up to {self.longest_ms:.0f} ms"


Rows = dict[tuple[str, int], ModelRow]
"""By scene and MU."""


@dataclass(frozen=True, slots=True)
class Difference:
    """One place where model and thesis are apart, in words."""

    where: str
    section: str
    thesis: str
    model: str
    is_figure: bool = False


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


def of(run: Run) -> Rows:
    """Find the rows of a run by scene and MU; what is no such row is left out."""
    found: Rows = {}
    for given in run.client2004:
        try:
            row = ModelRow.model_validate(given)
        except ValidationError:
            continue
        found[row.scene, row.mu_ms] = row
    return found


def agreement(model: Rows) -> tuple[int, int]:
    """In how many cells both or neither have pauses, and of how many the thesis speaks."""
    both = [
        clean == row.is_clean
        for (scene, mu_ms), row in model.items()
        if scene in SAID and (clean := SAID[scene].is_clean(mu_ms)) is not None
    ]
    return sum(both), len(both)


def differences(model: Rows) -> list[Difference]:
    """Hold every row against the thesis's words, and what follows from them against its figures."""
    found = []
    for (scene, mu_ms), row in model.items():
        said = SAID.get(scene)
        if said is None or mu_ms not in said.texts:
            continue
        longest_ms = said.longest_ms.get(mu_ms)
        is_far = longest_ms is not None and not (
            longest_ms / FAR <= row.longest_ms <= longest_ms * FAR
        )
        if said.is_clean(mu_ms) != row.is_clean or is_far:
            section = "5.2.2" if scene.startswith("Internet") else "5.2.1"
            found.append(Difference(f"{scene}, {mu_ms} ms", section, said.texts[mu_ms], row.words))
    return [*found, *_figures(model)]


def _figures(model: Rows) -> list[Difference]:
    """Name the figures of which the model says another thing."""
    found = []
    short, long = model.get(("campus", 100)), model.get(("campus", 200))
    if short and long and not 0.35 <= _ratio(long.pauses_per_s, short.pauses_per_s) <= 0.65:
        found.append(
            Difference(
                "Figure 5.33",
                "5.2.1.5, Figure 5.33",
                "on the campus from 100 to 200 ms half as many pauses, as long as before",
                f"with 100 ms {short.words}; with 200 ms {long.words}",
                is_figure=True,
            )
        )
    short, long = model.get(("Internet, Linux", 100)), model.get(("Internet, Linux", 200))
    if short and long:
        # Of as much sound as 14 pauses came in with 100 ms.
        sound = _ratio(1 - short.silence, short.pauses_per_s)
        pauses = 14 * _ratio(sound * long.pauses_per_s, 1 - long.silence)
        if not 3 <= round(pauses) <= 5:
            found.append(
                Difference(
                    "Figure 5.44",
                    "5.2.2.6, Figure 5.44",
                    "from 100 to 200 ms the pauses of the run fall from 14 to 4",
                    f"over as much sound from 14 to {pauses:.0f}",
                    is_figure=True,
                )
            )
    return found


def _ratio(one: float, other: float) -> float:
    return one / other if other else 0.0
