"""`audio-master`, "Smooth" on the page: the sound sets its own delay, and the picture follows.

Thesis 3.3: people notice gaps in sound, so it is the master and never waits for a late picture; the
picture is held back to match it, by at most `max_holdback_ms`. If the sound would still be
noticeably late (`hold_back`), delivery comes before synchronisation: neither waits.
"""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING, Final

from wax.sentence import Sentence
from wax.sync.hold_back import HoldBack
from wax.sync.playout import PlayoutTargets
from wax.sync.playout_state import PlayoutState

if TYPE_CHECKING:
    from wax.config.sync import SyncSettings
    from wax.congestion.allocation import Allocation
    from wax.congestion.control import LinkEstimate
    from wax.sync.playout import PlayoutReport, StreamPlayout

_AUTO_PREROLL_MS: Final = 40.0
"""A browser's buffer settles at this on a good link."""

_SPREAD_MS: Final = 20.0
"""The spread of single measurements: a screen refreshes every 17 ms, and pictures are held back in
steps of 10 ms. The skew stays this far inside the tolerance."""

_USUAL_ROUND_TRIP_S: Final = 0.1
"""The assumed round trip before one is measured. Ours."""


class AudioMaster:
    """Holds the picture back by the *measured* ages of both streams, not by the browser's lip sync.

    Ages count up to the screen and the ear, so that a headset's delay holds the picture back, too
    (thesis 5.3.1). If a browser cannot report them, the buffers' delays are compared instead.
    """

    def __init__(self, settings: SyncSettings, state: PlayoutState | None = None) -> None:
        self.state = state or PlayoutState()
        self.state.configure(settings)
        late_ms = max(settings.max_skew_ms - _SPREAD_MS, 0.0)
        fixed_ms = self.state.sound.fixed_ms
        self._hold = HoldBack(
            late_ms=late_ms,
            max_ms=settings.max_holdback_ms,
            held_ms=0.0 if fixed_ms is None else fixed_ms - late_ms,
        )

    @property
    def name(self) -> str:
        return "audio-master"

    @property
    def preroll_ms(self) -> float:
        return self.state.sound.target_ms or _AUTO_PREROLL_MS

    def start(self) -> PlayoutTargets:
        return self._targets(Sentence("sync.begin"))

    def decide(
        self,
        report: PlayoutReport,
        now_s: float,
        estimate: LinkEstimate | None = None,
        allocation: Allocation | None = None,
    ) -> PlayoutTargets:
        self.state.update(report, now_s, estimate, allocation)
        now_s = self.state.now_s
        if self.state.delivery_first.reason is not None:
            self._hold.restart(0.0, now_s)
            return PlayoutTargets(
                sound_ms=self.state.sound.target_ms,
                picture_ms=0.0,
                reason=Sentence("sync.apart", {"why": self.state.delivery_first.reason}),
                in_step=False,
            )
        if report.picture is not None:
            self._hold.observe_picture(report.picture.age_ms, report.picture.delay_ms, now_s)
        if report.sound is None:
            self._hold.restart(0.0, now_s)
            return self._targets(Sentence("sync.no_sound"))
        if report.picture is None:
            self._hold.restart(self._hold.held_ms, now_s)
            return self._targets(Sentence("sync.no_picture"))
        return self._targets(
            self._update_hold_back(report.sound, report.picture, _round_trip_s(estimate))
        )

    def _update_hold_back(
        self, sound: StreamPlayout, picture: StreamPlayout, round_trip_s: float
    ) -> Sentence:
        """Update the hold-back from the measurements; return the reason."""
        early_ms = _early_ms(sound, picture)
        if early_ms is None:
            return Sentence("sync.first")
        self._hold.update(early_ms, round_trip_s, self.state.now_s)
        if self._hold.is_at_once(self.state.now_s):
            return Sentence("sync.stood")
        if self._hold.is_in_vain:
            return Sentence("sync.in_vain")
        if self._hold.is_short:
            return Sentence("sync.short")
        if self._hold.held_ms == 0:
            return Sentence("sync.nothing")
        return Sentence("sync.follows")

    def _targets(self, reason: Sentence) -> PlayoutTargets:
        return PlayoutTargets(
            sound_ms=self.state.sound.target_ms, picture_ms=self._hold.held_ms, reason=reason
        )


def _early_ms(sound: StreamPlayout, picture: StreamPlayout) -> float | None:
    """Return how much younger the picture is than the sound; None if unknown."""
    ages = _difference(sound.age_ms, picture.age_ms)
    return _difference(sound.delay_ms, picture.delay_ms) if ages is None else ages


def _difference(sound_ms: float | None, picture_ms: float | None) -> float | None:
    if sound_ms is None or picture_ms is None:
        return None
    return sound_ms - picture_ms if isfinite(sound_ms - picture_ms) else None


def _round_trip_s(estimate: LinkEstimate | None) -> float:
    if estimate is None or estimate.round_trip_ms is None or not isfinite(estimate.round_trip_ms):
        return _USUAL_ROUND_TRIP_S
    return min(max(estimate.round_trip_ms / 1000, 0.0), 2.0)
