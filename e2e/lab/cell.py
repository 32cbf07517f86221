"""One cell of the lab: which system is watched over which link, by whom and for how long."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict

Experiment = Literal["E1", "E2", "E3", "E4", "E5", "E6", "G"]
"""``G`` is what issue 4's goals are judged by."""
SystemName = Literal["thesis", "audio-master", "operator", "video-first", "stock", "livekit"]
"""``audio-master`` is the observer's default, ``operator`` what a driver gets, on the page too."""


class Cell(BaseModel):
    """What is done once; two cells with the same `key` are the same measurement."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    experiment: Experiment
    profile: str
    system: SystemName
    audio_mu_ms: int | None = None
    """Only for ``thesis``; 500 where it is None."""
    content: Literal["testcard", "face"] = "testcard"
    browser: Literal["chromium", "firefox"] = "chromium"
    viewers: int = 1
    """All but the first only count what they get (E5)."""
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
        parts: list[str] = [self.experiment, self.profile, self.system]
        if self.audio_mu_ms is not None:
            parts.append(f"{self.audio_mu_ms}ms")
        if self.content != "testcard":
            parts.append(self.content)
        if self.browser != "chromium":
            parts.append(self.browser)
        if self.viewers != 1:
            parts.append(f"{self.viewers}-viewers")
        if self.slow:
            parts.append(f"{self.slow}-slow")
        if self.drives:
            parts.append("drives")
        if self.seconds != 15.0:
            parts.append(f"{self.seconds:g}s")
        return "/".join(parts)

    @property
    def key(self) -> str:
        return f"{self.variant}/{self.repeat}"
