"""The virtual clock between the two streams (thesis 3.3.3)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from wax.baseline.equations import hold_back_s, pictures_to_cache

if TYPE_CHECKING:
    from wax.baseline.media_units import MediaUnit
    from wax.config.thesis import ThesisSettings


class VirtualClock:
    """Decides when pictures are due; it starts when the first audio MU, A_1, is sent.

    A_1 plays from its beginning, which is then `rollback_s` old: one audio MU plus its wait at the
    source. The picture is rolled back by as much.
    """

    def __init__(self, settings: ThesisSettings, first: MediaUnit, now_s: float) -> None:
        self._video_mu_ms = settings.video_mu_ms
        self._audio_mu_ms = settings.audio_mu_ms
        self._first = first
        # The first MU waited in the slot for at most one MU length. A source that delivers it much
        # later after its capture must not roll the picture back without bound.
        self._rollback_s = min(max(now_s - first.captured_s, 0.0), 2 * first.duration_s)
        self.extra_s = 0.0
        """Roll-back beyond the clock's own, for a client that buffers more sound (5.3.1)."""

    @property
    def rollback_s(self) -> float:
        return self._rollback_s + self.extra_s

    def due_s(self, picture: MediaUnit) -> float:
        """Return when a picture is due to leave."""
        return picture.captured_s + self.rollback_s

    def hold_back_s(self, newest: MediaUnit) -> float:
        """Return T_p for V_2, the newest picture (3.1)."""
        return hold_back_s(self._first.captured_s, newest.captured_s)

    def capacity(self, transfer_s: float) -> int:
        """Return how many pictures to cache: N_v, or more if the roll-back exceeds A.

        The cache then spans the roll-back as it spans A in (3.2) and (3.3). If a picture takes less
        than V no picture may be skipped, so the capacity is rounded up.
        """
        pictures = pictures_to_cache(
            transfer_s * 1000, audio_mu_ms=self._audio_mu_ms, video_mu_ms=self._video_mu_ms
        )
        transfer_ms = transfer_s * 1000
        rollback_ms = self.rollback_s * 1000
        if transfer_ms >= self._audio_mu_ms or rollback_ms <= self._audio_mu_ms:
            return pictures
        if transfer_ms < self._video_mu_ms:
            # A millisecond beyond a whole number of pictures is due to the timer, not the link.
            return max(pictures, math.ceil((rollback_ms - 1) / self._video_mu_ms) - 1)
        return max(pictures, int(rollback_ms // transfer_ms) - 1)
