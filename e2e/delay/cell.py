"""One cell of the lab: which system is watched over which link, by whom and for how long."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict

from e2e.delay.names import CHANGING

Experiment = Literal["E1", "E2", "E3", "E4", "E5", "E6", "G"]
"""``G`` is what the goals are judged by."""
SystemName = Literal[
    "thesis", "audio-master", "operator", "video-first", "stock", "livekit", "livekit-whip"
]
"""``audio-master`` is the observer's default, ``operator`` what a driver gets, on the page too.

``livekit`` is published by its Python SDK as its quick start has it, ``livekit-whip`` by WHIP with
one layer.
"""


class Cell(BaseModel):
    """What is done once; two cells with the same `key` are the same measurement."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    experiment: Experiment
    profile: str
    system: SystemName
    audio_mu_ms: int | None = None
    """Only for ``thesis``; 500 where it is None."""
    content: Literal["testcard", "talking-head"] = "testcard"
    browser: Literal["chromium", "firefox"] = "chromium"
    player: Literal["auto", "browser", "own"] = "auto"
    """Who plays WAX's sound on the page."""
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
        if self.player != "auto":
            parts.append(f"{self.player}-player")
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

    @property
    def mu_ms(self) -> int | None:
        """The thesis policy's audio MU; None for a system that has none to choose."""
        return (self.audio_mu_ms or 500) if self.system == "thesis" else None

    @property
    def is_changing(self) -> bool:
        return self.experiment == "E6" or self.profile in CHANGING

    @property
    def is_alone(self) -> bool:
        """Whether one viewer watches the test card in Chromium and does not drive."""
        return (self.viewers, self.browser, self.content, self.drives) == (
            1,
            "chromium",
            "testcard",
            False,
        )

    @property
    def is_plain(self) -> bool:
        """Whether it is alone on a link that does not change, with the thesis's own MU."""
        return self.is_alone and not self.is_changing and self.mu_ms in {None, 500}
