"""`video-first`: neither stream waits for the other; the skew is shown, not enforced."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.sync.playout import PlayoutTargets

if TYPE_CHECKING:
    from wax.config import SyncSettings
    from wax.sync.playout import PlayoutReport


class VideoFirst:
    """The sound keeps its own delay, the picture is shown as soon as it is there."""

    def __init__(self, settings: SyncSettings) -> None:
        delay = settings.audio_delay_ms
        self._targets = PlayoutTargets(
            sound_ms=None if delay == "auto" else float(delay),
            picture_ms=0.0,
            reason="neither waits for the other",
        )

    @property
    def name(self) -> str:
        return "video-first"

    @property
    def preroll_ms(self) -> float:
        return self._targets.sound_ms or 0.0

    def start(self) -> PlayoutTargets:
        return self._targets

    def decide(self, report: PlayoutReport, now_s: float) -> PlayoutTargets:  # noqa: ARG002  # the protocol's form; this policy needs neither
        return self._targets
