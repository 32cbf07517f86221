"""One cell: which system is watched over which link, by whom and for how long."""

from __future__ import annotations

from typing import Final, Literal

from pydantic import BaseModel, ConfigDict

from e2e.delay.names import SystemName, shown

GOALS: Final = "G"


class Cell(BaseModel):
    """What is done once; two cells with the same `key` are the same measurement."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    experiment: str = GOALS
    """What for: the goals, or what only a long run measures (`e2e.delay.plan`)."""
    profile: str
    system: SystemName
    audio_mu_ms: int | None = None
    """Only for ``thesis``; 500 where it is None."""
    player: Literal["auto", "browser", "built-in"] = "auto"
    """Who plays WAX's sound on the page."""
    viewers: int = 1
    """All but the first only count what they get."""
    slow: int = 0
    """So many of those are behind a modem each."""
    drives: bool = False
    """Whether the page holds a key all the time; only for ``operator``."""
    seconds: float = 15.0
    """How long is measured, from the first picture on."""
    repeat: int = 0
    """Which repetition this is, and what seeds the link's chance."""

    @property
    def variant(self) -> str:
        """The same for all repetitions of a cell."""
        parts: list[str] = [] if self.experiment == GOALS else [self.experiment]
        parts += [shown(self.profile), self.system]
        if self.audio_mu_ms is not None:
            parts.append(f"{self.audio_mu_ms}ms")
        if self.player != "auto":
            parts.append(f"{self.player}-player")
        if self.viewers != 1:
            parts.append(f"{self.viewers}-viewers")
        return "/".join(parts)

    @property
    def key(self) -> str:
        return f"{self.variant}/{self.repeat}"
