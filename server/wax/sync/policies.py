"""From the name in the configuration to the policy."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.sync.audio_master import AudioMaster
from wax.sync.video_first import VideoFirst

if TYPE_CHECKING:
    from wax.config.settings import SyncSettings
    from wax.sync.playout import PlayoutPolicy
    from wax.sync.playout_state import PlayoutState


def make_policy(settings: SyncSettings, watch: PlayoutState | None = None) -> PlayoutPolicy:
    """Make a fresh policy for one viewer in one role.

    `watch` is that of the policy before, if there was one: what it knows of the link stays true.
    """
    if settings.policy == "video-first":
        return VideoFirst(settings, watch)
    return AudioMaster(settings, watch)
