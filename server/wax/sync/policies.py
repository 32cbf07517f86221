"""From the name in the configuration to the policy."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.sync.audio_master import AudioMaster
from wax.sync.video_first import VideoFirst

if TYPE_CHECKING:
    from wax.config import SyncSettings
    from wax.sync.playout import PlayoutPolicy


def make_policy(settings: SyncSettings) -> PlayoutPolicy:
    """Make a fresh policy for one viewer in one role."""
    if settings.policy == "video-first":
        return VideoFirst(settings)
    return AudioMaster(settings)
