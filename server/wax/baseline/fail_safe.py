"""Fail-safe mode: everything as soon as possible, no synchronisation (thesis 3.3, 3.5)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from wax.sentence import Sentence

if TYPE_CHECKING:
    from wax.config.thesis import ThesisSettings


@dataclass(frozen=True, slots=True)
class LinkMeasurements:
    """Measurements that show whether the link is sufficient; None if not known yet.

    `interval_s` is how long one picture blocks the next. `sound_delay_s` is the sound's end-to-end
    delay, from when an MU could have been sent until its arrival.
    """

    transfer_s: float | None = None
    interval_s: float | None = None
    sound_delay_s: float | None = None


def insufficient(measured: LinkMeasurements, settings: ThesisSettings) -> Sentence | None:
    """Return why the link is insufficient, None if it is sufficient.

    It is insufficient if T_r >= A (3.4), if less than one picture a second gets through, or if the
    sound's end-to-end delay is longer than an audio MU (3.5). Exactly one of either suffices.
    """
    audio_mu_s = settings.audio_mu_ms / 1000
    if measured.transfer_s is not None and measured.transfer_s >= audio_mu_s:
        return Sentence("thesis.long_transfer")
    if measured.interval_s is not None and measured.interval_s * settings.fail_safe_fps > 1:
        return Sentence("thesis.few_pictures")
    if measured.sound_delay_s is not None and measured.sound_delay_s > audio_mu_s:
        return Sentence("thesis.late_sound")
    return None


class BaselineFailSafe:
    """Enters fail-safe mode at once, and leaves it after `recover_ms` without a reason."""

    def __init__(self, settings: ThesisSettings) -> None:
        self._settings = settings
        self._sufficient_since_s: float | None = None
        self.reason: Sentence | None = None

    @property
    def is_active(self) -> bool:
        return self.reason is not None

    def update(self, measured: LinkMeasurements, now_s: float) -> None:
        """Update from new measurements; `now_s` never falls."""
        reason = insufficient(measured, self._settings)
        if reason is not None:
            self.reason = reason
            self._sufficient_since_s = None
        elif self.is_active:
            if self._sufficient_since_s is None:
                self._sufficient_since_s = now_s
            if now_s - self._sufficient_since_s >= self._settings.recover_ms / 1000:
                self.leave()

    def leave(self) -> None:
        """Leave fail-safe mode regardless of the link, as when only one stream is wanted."""
        self.reason = None
        self._sufficient_since_s = None
