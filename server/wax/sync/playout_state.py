"""What the live policies know about one viewer's link; it survives a change of policy."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING

from wax.sync.delivery_first import DeliveryFirst, insufficient
from wax.sync.playout import StreamPlayout
from wax.sync.sound_delay import SoundDelay

if TYPE_CHECKING:
    from wax.config.sync import SyncSettings
    from wax.congestion.allocation import Allocation
    from wax.congestion.control import LinkEstimate
    from wax.sentence import Sentence
    from wax.sync.playout import PlayoutReport

_USUAL_MU_MS = 20


class PlayoutState:
    """The sound's delay, and whether the link carries both streams in sync."""

    def __init__(self) -> None:
        self.sound = SoundDelay(None)
        self.delivery_first = DeliveryFirst()
        self.now_s = float("-inf")

    def configure(self, settings: SyncSettings) -> None:
        """Apply the configured delay; keep an adapted delay if it is unchanged."""
        delay = settings.audio_delay_ms
        fixed_ms = None if delay == "auto" else float(delay)
        if fixed_ms != self.sound.fixed_ms:
            self.sound = SoundDelay(fixed_ms)

    def update(
        self,
        report: PlayoutReport,
        now_s: float,
        estimate: LinkEstimate | None,
        allocation: Allocation | None,
    ) -> None:
        """Update from a report and the state of the link at that time."""
        self.now_s = max(now_s, self.now_s) if isfinite(now_s) else self.now_s
        heard = report.sound or StreamPlayout()
        encoding = None if allocation is None else allocation.sound
        self.sound.decide(
            jitter_ms=0.0 if estimate is None else estimate.jitter_ms,
            mu_ms=_USUAL_MU_MS if encoding is None else encoding.mu_ms,
            redundancy=0 if allocation is None or encoding is None else allocation.redundancy,
            concealed_ms=heard.concealed_ms,
            played_ms=heard.played_ms,
            output_ms=heard.output_ms,
            now_s=self.now_s,
            lost=0.0 if estimate is None else estimate.lost,
            burst=0 if estimate is None else estimate.burst,
            is_congested=estimate is not None and estimate.state == "congested",
            learns=not self.delivery_first.is_active and not heard.is_built_in,
        )
        if heard.is_built_in:
            self.sound.restart()  # that player sets its own delay
        if report.sound is None or report.picture is None:
            self.delivery_first.leave()
            return
        self.delivery_first.update(self._trouble(estimate, allocation), self.now_s)
        if self.delivery_first.is_active and self.sound.is_useless:
            self.sound.restart()

    def _trouble(
        self, estimate: LinkEstimate | None, allocation: Allocation | None
    ) -> Sentence | None:
        still = self.delivery_first.reason if self.sound.is_breaking else None
        return insufficient(estimate, allocation, self.sound) or still
