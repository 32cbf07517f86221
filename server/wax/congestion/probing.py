"""How fast pictures leave, so that they find out what the link carries without hurting sound."""

from __future__ import annotations

from typing import Final

STARTING_RATE_BPS: Final = 300_000.0
"""What is taken for the rate while nothing is known."""
ENOUGH_BPS: Final = 20_000_000.0
"""More is not looked for."""

_STARTING_FACTOR: Final = 4.0
_FACTOR: Final = 2.0
_WORTH: Final = 1.15
_DELAY_S: Final = 0.050
_UNFELT_DELAY_S: Final = 0.010
_CLIMB_S: Final = 1.0
_FIRST_PAUSE_S: Final = 1.0
_LONGEST_PAUSE_S: Final = 30.0


class Prober:
    """Paces each picture; `now_s` never falls.

    If the link carries no more than is known, a picture that leaves faster delays the sound behind
    it. By 10 ms every picture may; by up to 50 ms one in a while, which becomes longer while
    nothing comes of it, and all of them while the rate is rising.
    """

    def __init__(self) -> None:
        self._climbs_until_s = 0.0
        self._next_s = 0.0
        self._pause_s = _FIRST_PAUSE_S

    def pace_bps(
        self, size_bytes: int, rate_bps: float, *, starting: bool, lossy: bool, now_s: float
    ) -> tuple[float, bool]:
        """Return the pace, and whether it is worth more packets than the picture needs.

        Where the way is `lossy`, the queue may be too short for what leaves fast.
        """
        if rate_bps >= ENOUGH_BPS or size_bytes <= 0:
            return rate_bps, False
        bits = size_bytes * 8
        unfelt_bps = _fastest_bps(rate_bps, bits, _UNFELT_DELAY_S, _FACTOR)
        climbing = starting or now_s < self._climbs_until_s
        if not climbing and now_s < self._next_s:
            worth = unfelt_bps >= _WORTH * rate_bps and not lossy
            return (unfelt_bps if worth else rate_bps), False
        factor = _STARTING_FACTOR if starting else _FACTOR
        pace_bps = _fastest_bps(rate_bps, bits, _DELAY_S, factor)
        if pace_bps < _WORTH * rate_bps:
            return rate_bps, False
        if not climbing:
            self._next_s = now_s + self._pause_s
            self._pause_s = min(2 * self._pause_s, _LONGEST_PAUSE_S)
        return min(pace_bps, ENOUGH_BPS), True

    def risen(self, now_s: float) -> None:
        """Go on: the rate has risen."""
        self._climbs_until_s = now_s + _CLIMB_S
        self._next_s = now_s + _CLIMB_S
        self._pause_s = _FIRST_PAUSE_S

    def fallen(self, now_s: float) -> None:
        """Look soon whether the rate that fell comes back, but not at once."""
        self._climbs_until_s = now_s
        self._next_s = now_s + _FIRST_PAUSE_S
        self._pause_s = _FIRST_PAUSE_S


def _fastest_bps(rate_bps: float, bits: int, delay_s: float, factor: float) -> float:
    """Return the pace at which a link of just this rate is `delay_s` behind after the picture."""
    slack = bits / rate_bps - delay_s
    if slack <= bits / (factor * rate_bps):
        return factor * rate_bps
    return bits / slack
