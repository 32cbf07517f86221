"""What a synchronisation policy is, and which one the configuration names."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from wax.sync.audio_master import AudioMaster
from wax.sync.video_first import VideoFirst

if TYPE_CHECKING:
    from wax.config.settings import SyncSettings
    from wax.congestion.allocation import Allocation
    from wax.congestion.delivery import LinkEstimate
    from wax.sync.playout import PlayoutReport, PlayoutTargets
    from wax.sync.playout_state import PlayoutState


class PlayoutPolicy(Protocol):
    """Decides for one viewer; holds no clock and does no input or output."""

    @property
    def name(self) -> str: ...

    @property
    def state(self) -> PlayoutState:
        """What it knows of the viewer's link, for the policy that follows it."""
        ...

    @property
    def preroll_ms(self) -> float:
        """How much past sound to begin with, so that its buffer is full at once."""
        ...

    def start(self) -> PlayoutTargets:
        """Return the targets before anything has been measured."""
        ...

    def decide(
        self,
        report: PlayoutReport,
        now_s: float,
        estimate: LinkEstimate | None = None,
        allocation: Allocation | None = None,
    ) -> PlayoutTargets:
        """Return the targets after a report, with the newest estimate of the link and what is sent.

        A `now_s` that falls counts as one that stands still.
        """
        ...


def make_policy(settings: SyncSettings, state: PlayoutState | None = None) -> PlayoutPolicy:
    """Make a fresh policy for one viewer in one role.

    `state` is that of the policy before, if there was one: what it knows of the link stays true.
    """
    if settings.policy == "video-first":
        return VideoFirst(settings, state)
    return AudioMaster(settings, state)
