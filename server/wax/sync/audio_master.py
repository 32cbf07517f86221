"""`audio-master`: the sound plays at its own delay, the picture is held back to meet it.

Thesis 3.3: people do not forgive gaps in sound, so it is the master and is never delayed for a
late picture; the picture rolls back to it, and where it would have to wait longer than
`max_holdback_ms` delivery comes before synchronisation.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.sync.playout import PlayoutTargets

if TYPE_CHECKING:
    from wax.config import SyncSettings
    from wax.sync.playout import PlayoutReport, StreamPlayout

_AUTO_PREROLL_MS: Final = 40.0
"""What a browser's buffer settles at by itself on a good link."""

_RATE_PER_S: Final = 2.5
"""How fast the hold-back closes on the measured skew: 63 % of it in 0.4 s."""

_MAX_STEP_S: Final = 0.4
"""After a silence of the reports one report still moves the hold-back by this much time."""


class AudioMaster:
    """Holds the picture by the *measured* ages of both streams, not by a browser's own coupling.

    Where a browser cannot tell the ages, the sound's measured buffer delay is followed instead.
    """

    def __init__(self, settings: SyncSettings) -> None:
        self._settings = settings
        delay = settings.audio_delay_ms
        self._sound_ms = None if delay == "auto" else float(delay)
        self._held_ms = min(self._sound_ms or 0.0, settings.max_holdback_ms)
        self._decided_s: float | None = None

    @property
    def name(self) -> str:
        return "audio-master"

    @property
    def preroll_ms(self) -> float:
        return _AUTO_PREROLL_MS if self._sound_ms is None else self._sound_ms

    def start(self) -> PlayoutTargets:
        return self._targets("the sound sets the time")

    def decide(self, report: PlayoutReport, now_s: float) -> PlayoutTargets:
        elapsed_s = 0.0 if self._decided_s is None else now_s - self._decided_s
        self._decided_s = now_s
        if report.picture is None:
            return self._targets("no picture to hold back")
        if report.sound is None:
            self._held_ms = 0.0
            return self._targets("no sound to wait for")
        early_ms = _early_ms(report.sound, report.picture)
        if early_ms is None:
            return self._targets("waiting for the first measurement")
        # Half the allowed skew is left alone: the measurement itself is no finer.
        if abs(early_ms) > self._settings.max_skew_ms / 2:
            step = min(max(elapsed_s, 0.0), _MAX_STEP_S) * _RATE_PER_S
            self._held_ms += min(step, 1.0) * early_ms
        ceiling_ms = self._settings.max_holdback_ms
        if self._held_ms > ceiling_ms:
            self._held_ms = ceiling_ms
            return self._targets("the picture is held back as long as allowed")
        self._held_ms = max(self._held_ms, 0.0)
        return self._targets("the picture follows the sound")

    def _targets(self, reason: str) -> PlayoutTargets:
        return PlayoutTargets(
            sound_ms=self._sound_ms, picture_ms=round(self._held_ms, 1), reason=reason
        )


def _early_ms(sound: StreamPlayout, picture: StreamPlayout) -> float | None:
    """Return how much younger than the sound the picture is shown, None where unknown."""
    if sound.age_ms is not None and picture.age_ms is not None:
        return sound.age_ms - picture.age_ms
    if sound.delay_ms is not None and picture.delay_ms is not None:
        return sound.delay_ms - picture.delay_ms
    return None
