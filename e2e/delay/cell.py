"""One cell: which system is watched over which link, by whom and for how long."""

from __future__ import annotations

from typing import Final, Literal

from pydantic import BaseModel, ConfigDict

from e2e.delay.names import SystemName, shown
from e2e.peers.sizes import SIZES, VGA, Size, SizeName

GOALS: Final = "G"


class Cell(BaseModel):
    """One measurement; two cells with the same `key` are repetitions of it."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    experiment: str = GOALS
    """The purpose: the goals, or what only a long run measures (`e2e.delay.plan`)."""
    profile: str
    system: SystemName
    audio_mu_ms: int | None = None
    """Only for ``thesis``; None means 500."""
    player: Literal["auto", "browser", "built-in"] = "auto"
    """Which player plays WAX's sound on the page."""
    size: SizeName = "640x480"
    """The size of the source, which fixes the highest bit rate too (`e2e.peers.sizes`)."""
    viewers: int = 1
    """The number of viewers; all but the first only count what they get."""
    slow: int = 0
    """This many of the viewers are behind a modem each."""
    drives: bool = False
    """Whether the page holds a key all the time; only for ``operator``."""
    seconds: float = 15.0
    """How long is measured, from the first picture on."""
    repeat: int = 0
    """The number of the repetition, which also seeds the link's random choices."""

    @property
    def given(self) -> Size:
        return SIZES[self.size]

    @property
    def variant(self) -> str:
        """The same for all repetitions of a cell."""
        parts: list[str] = [] if self.experiment == GOALS else [self.experiment]
        parts += [shown(self.profile), self.system]
        if self.audio_mu_ms is not None:
            parts.append(f"{self.audio_mu_ms}ms")
        if self.player != "auto":
            parts.append(f"{self.player}-player")
        if self.given is not VGA:
            parts.append(self.size)
        if self.viewers != 1:
            parts.append(f"{self.viewers}-viewers")
        return "/".join(parts)

    @property
    def key(self) -> str:
        return f"{self.variant}/{self.repeat}"
