"""Fail-safe mode: everything as soon as possible, no synchronisation (thesis 3.3, 3.5)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from wax.config.thesis import ThesisSettings


@dataclass(frozen=True, slots=True)
class Signs:
    """What says whether the link is sufficient; None where nothing is known yet.

    `interval_s` is how long one picture keeps the next from leaving, `sound_delay_s` the sound's
    end-to-end delay: from when an MU could have been sent until it is there.
    """

    transfer_s: float | None = None
    interval_s: float | None = None
    sound_delay_s: float | None = None


def insufficient(signs: Signs, settings: ThesisSettings) -> str | None:
    """Say why the link is insufficient, None when it is not.

    T_r >= A (3.4); less than one picture a second gets through, or the sound's end-to-end delay
    is longer than an audio MU (3.5). One picture a second, and a delay of just one MU, will do.
    """
    audio_mu_s = settings.audio_mu_ms / 1000
    if signs.transfer_s is not None and signs.transfer_s >= audio_mu_s:
        return "a picture takes as long as an audio media unit, or longer"
    if signs.interval_s is not None and signs.interval_s * settings.fail_safe_fps > 1:
        return "too few pictures a second get through"
    if signs.sound_delay_s is not None and signs.sound_delay_s > audio_mu_s:
        return "the sound is later than one audio media unit"
    return None


class BaselineFailSafe:
    """Entered at once, left when there was no reason for it for `recover_ms`."""

    def __init__(self, settings: ThesisSettings) -> None:
        self._settings = settings
        self._sufficient_since_s: float | None = None
        self.reason: str | None = None

    @property
    def is_active(self) -> bool:
        return self.reason is not None

    def update(self, signs: Signs, now_s: float) -> None:
        """Judge anew; `now_s` never falls."""
        reason = insufficient(signs, self._settings)
        if reason is not None:
            self.reason = reason
            self._sufficient_since_s = None
        elif self.is_active:
            if self._sufficient_since_s is None:
                self._sufficient_since_s = now_s
            if now_s - self._sufficient_since_s >= self._settings.recover_ms / 1000:
                self.leave()

    def leave(self) -> None:
        """Leave it whatever the link, as when only one stream is asked for any more."""
        self.reason = None
        self._sufficient_since_s = None
