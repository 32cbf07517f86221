"""The virtual clock between the two streams (thesis 3.3.3)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from wax.baseline.equations import hold_back_s, pictures_to_cache

if TYPE_CHECKING:
    from wax.baseline.media_units import MediaUnit
    from wax.config.thesis import ThesisSettings


class VirtualClock:
    """Says when pictures are due; started by the first audio MU, A_1, as it leaves.

    A_1 is heard from its beginning, which is then `rollback_s` old: one audio MU, and as much
    more as it had waited at the source. The picture is rolled back as far.
    """

    def __init__(self, settings: ThesisSettings, first: MediaUnit, now_s: float) -> None:
        self._video_mu_ms = settings.video_mu_ms
        self._audio_mu_ms = settings.audio_mu_ms
        self._first = first
        # It waited at most one MU length in the slot; a source that hands it in later than
        # that after its capture shall not roll back the picture without end.
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
        """Return how many pictures to cache: N_v, and more where the roll-back is beyond A.

        The cache then spans the roll-back as by (3.2) and (3.3) it spans A. Where a picture
        takes less than V it must not cost a single one, so there the places are rounded up.
        """
        pictures = pictures_to_cache(
            transfer_s * 1000, audio_mu_ms=self._audio_mu_ms, video_mu_ms=self._video_mu_ms
        )
        transfer_ms = transfer_s * 1000
        rollback_ms = self.rollback_s * 1000
        if transfer_ms >= self._audio_mu_ms or rollback_ms <= self._audio_mu_ms:
            return pictures
        if transfer_ms < self._video_mu_ms:
            # A millisecond more than a whole number of pictures is the timer's, not the link's.
            return max(pictures, math.ceil((rollback_ms - 1) / self._video_mu_ms) - 1)
        return max(pictures, int(rollback_ms // transfer_ms) - 1)
