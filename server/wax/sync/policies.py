"""The interface of a synchronisation policy, and its construction from the configuration."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from wax.sync.audio_master import AudioMaster
from wax.sync.video_first import VideoFirst

if TYPE_CHECKING:
    from wax.config.sync import SyncSettings
    from wax.congestion.allocation import Allocation
    from wax.congestion.control import LinkEstimate
    from wax.sync.playout import PlayoutReport, PlayoutTargets
    from wax.sync.playout_state import PlayoutState


class PlayoutPolicy(Protocol):
    """Decides for one viewer, without a clock and without input or output."""

    @property
    def name(self) -> str: ...

    @property
    def state(self) -> PlayoutState:
        """The knowledge about the viewer's link, to pass to the next policy."""
        ...

    @property
    def preroll_ms(self) -> float:
        """The pre-roll of the sound, in ms, that fills its buffer at once."""
        ...

    def start(self) -> PlayoutTargets:
        """Return the targets before any measurement."""
        ...

    def decide(
        self,
        report: PlayoutReport,
        now_s: float,
        estimate: LinkEstimate | None = None,
        allocation: Allocation | None = None,
    ) -> PlayoutTargets:
        """Return the targets after a report, given the newest link estimate and allocation.

        A falling `now_s` counts as unchanged.
        """
        ...


def make_policy(settings: SyncSettings, state: PlayoutState | None = None) -> PlayoutPolicy:
    """Make a policy for one viewer in one role.

    `state` is the previous policy's, if any: its knowledge of the link stays valid.
    """
    if settings.policy == "video-first":
        return VideoFirst(settings, state)
    return AudioMaster(settings, state)
