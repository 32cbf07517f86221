"""Chooses the sound's encoding and redundancy, and what that leaves to the picture."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.congestion.upgrade_backoff import Since
from wax.congestion.wire_cost import sound_bps

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from wax.congestion.allocation import SoundEncoding
    from wax.congestion.control import LinkEstimate

FIT_SHARE: Final = 0.85
"""Share of the rate that a new choice may take; the rest is for keyframes and jitter."""
_PARTS: Final = 3
"""Sound takes at most one part in this many; its smallest encoding is always sent."""
_USUAL_MU_MS: Final = 60
"""Longer units add delay of their own, so they are used only if no picture would fit otherwise."""
_RISE_HOLD_S: Final = 5.0
"""An upgrade must have fitted for this long."""
REDUNDANCY_LOSS_SHARE: Final = 0.005
"""Redundancy (RFC 2198) starts here: one packet lost in 200, 20 ms every 4 s, is audible."""
_MAX_REDUNDANCY: Final = 3
"""Earlier units in a packet at most; waiting for them takes 60 ms."""
_REDUNDANCY_HOLD_S: Final = 10.0
"""Redundancy falls once less has been enough for this long, as long as loss is averaged."""


class SoundChoice:
    """Chooses the sound's encoding for one viewer; `now_s` never falls."""

    def __init__(self, encodings: Sequence[SoundEncoding]) -> None:
        self._rate_bps = self._other_bps = 0.0
        self._encodings = tuple(encodings)
        self._encoding: SoundEncoding | None = None
        self._better = Since()
        self._redundancy = 0
        self._fewer = Since()
        self._aim_bps = 0.0
        self._limits_bps: list[tuple[float, float]] = []
        """For each choice of sound, the least budget that allows it, and the rate that it takes."""

    def choose(
        self,
        estimate: LinkEstimate,
        other_bps: float,
        fixed: Sequence[SoundEncoding] | None,
        *,
        wanted: bool,
        channels: int,
        picture_bps: float,
        takes_redundancy: bool,
        now_s: float,
    ) -> tuple[SoundEncoding | None, int]:
        """Return the encoding, None if none is wanted, and how many earlier units a packet repeats.

        A downgrade is immediate, and so is an upgrade during startup; later an upgrade must have
        fitted for 5 s. `picture_bps` is the least that a picture takes; if it is 0, the sound may
        take everything. `channels` is how many the source has; an encoding with more is chosen
        only if there is no other.
        """
        self._rate_bps, self._other_bps = estimate.rate_bps, other_bps
        if not wanted:
            self._encoding, self._aim_bps, self._limits_bps = None, 0.0, []
            return None, 0
        offered = self._encodings if fixed is None else tuple(fixed)
        encodings = tuple(one for one in offered if one.channels <= channels) or offered
        repairs = takes_redundancy and estimate.lost >= REDUNDANCY_LOSS_SHARE
        useful = min(estimate.burst, _MAX_REDUNDANCY) if repairs else 0
        fewer = useful < self._redundancy
        if self._fewer.lasts(fewer, _REDUNDANCY_HOLD_S, now_s) or not fewer:
            self._redundancy, self._fewer = useful, Since()
        budget_bps = FIT_SHARE * estimate.rate_bps - other_bps
        third_bps = budget_bps / _PARTS if picture_bps else budget_bps
        usual = [one for one in encodings if one.mu_ms <= _USUAL_MU_MS] or encodings
        best = next((one for one in usual if sound_bps(one, 0) <= third_bps), usual[-1])
        if sound_bps(best, 0) > max(third_bps, budget_bps - picture_bps):
            best = encodings[-1]
        encoding = self._encoding
        rises = (
            encoding in encodings
            and estimate.state != "starting"
            and encodings.index(best) < encodings.index(encoding)
        )
        if encoding is None or not rises or self._better.lasts(rises, _RISE_HOLD_S, now_s):
            encoding, self._better = best, Since()
        self._encoding = encoding
        self._aim_bps = sound_bps(best, self._affordable(best, third_bps))
        self._limits_bps = list(self._limits(encodings, usual[-1], picture_bps))
        return encoding, self._affordable(encoding, third_bps)

    def left_bps(self, share: float) -> float:
        """Return what a `share` of the rate leaves to the picture, after `choose`.

        A faster link never leaves less: shortly before the next better sound fits, the picture
        gets no more than it will keep afterwards.
        """
        left_bps = share * self._rate_bps - self._other_bps - self._aim_bps
        budget_bps = FIT_SHARE * self._rate_bps - self._other_bps
        for least_bps, takes_bps in self._limits_bps:
            if least_bps > budget_bps:
                from_bps = (least_bps + self._other_bps) / FIT_SHARE
                left_bps = min(left_bps, share * from_bps - self._other_bps - takes_bps)
        return left_bps

    def _limits(
        self, encodings: tuple[SoundEncoding, ...], least: SoundEncoding, picture_bps: float
    ) -> Iterator[tuple[float, float]]:
        for encoding in encodings:
            for redundancy in range(self._redundancy + 1):
                takes_bps = sound_bps(encoding, redundancy)
                least_bps = takes_bps * _PARTS
                if encoding == least and not redundancy:
                    least_bps = min(least_bps, takes_bps + picture_bps)
                yield least_bps, takes_bps

    def _affordable(self, encoding: SoundEncoding, third_bps: float) -> int:
        counts = range(self._redundancy, 0, -1)
        return next((count for count in counts if sound_bps(encoding, count) <= third_bps), 0)
