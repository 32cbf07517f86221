"""`video-first`, "Immediate" on the page: neither stream waits; the skew is only displayed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.sentence import Sentence
from wax.sync.playout import PlayoutTargets
from wax.sync.playout_state import PlayoutState

if TYPE_CHECKING:
    from wax.config.sync import SyncSettings
    from wax.congestion.allocation import Allocation
    from wax.congestion.control import LinkEstimate
    from wax.sync.playout import PlayoutReport


class VideoFirst:
    """The sound keeps its own delay; the picture is shown as soon as it arrives."""

    def __init__(self, settings: SyncSettings, state: PlayoutState | None = None) -> None:
        self.state = state or PlayoutState()
        self.state.configure(settings)

    @property
    def name(self) -> str:
        return "video-first"

    @property
    def preroll_ms(self) -> float:
        return self.state.sound.target_ms or 0.0

    def start(self) -> PlayoutTargets:
        return PlayoutTargets(
            sound_ms=self.state.sound.target_ms,
            picture_ms=0.0,
            reason=Sentence("sync.neither"),
        )

    def decide(
        self,
        report: PlayoutReport,
        now_s: float,
        estimate: LinkEstimate | None = None,
        allocation: Allocation | None = None,
    ) -> PlayoutTargets:
        self.state.update(report, now_s, estimate, allocation)
        return self.start()
