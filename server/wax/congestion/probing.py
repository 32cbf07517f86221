"""Paces pictures so that they probe the link without delaying sound noticeably.

Pictures are the probes; nothing is padded. GCC's implementation sends clusters of padding at 3 and
6 times the first rate and then at twice the last result; BBR paces at 2.77 times its estimate at
startup and at 1.25 in ProbeBW_UP. Here the queue that a probe may build limits its cost.
"""

from __future__ import annotations

from typing import Final

STARTING_RATE_BPS: Final = 300_000.0
"""Assumed rate before any feedback. As libwebrtc."""
ENOUGH_BPS: Final = 20_000_000.0
"""Highest rate that is probed for: ten times the largest rendition's."""
_STARTUP_GAIN: Final = 4.0
"""Pacing gain of a probe at startup. libwebrtc: 3 and 6; BBR: 2.77."""
_PROBE_GAIN: Final = 2.0
"""Pacing gain of a probe afterwards. libwebrtc: 2; BBR: 1.25."""
_MIN_GAIN: Final = 1.15
"""Lowest gain of a probe: jitter hides the result of a slower one. Ours."""
_MAX_QUEUE_S: Final = 0.050
"""The queue that a probe may build if the link carries no more. NADA's QTH (RFC 8698) is the same;
a jitter buffer bridges it unheard."""
_CLIMB_S: Final = 1.0
"""For this long after a rise, every picture is a probe. Ours."""
_FIRST_PAUSE_S: Final = 1.0
"""Pause between the first two fruitless probes. Ours."""
_MAX_PAUSE_S: Final = 30.0
"""Longest pause between fruitless probes. libwebrtc probes every 5 s if the application limits the
rate, BBR every 2 to 3 s; ours delay sound."""
_BACKOFF_FACTOR: Final = 2.0
"""Each fruitless probe multiplies the pause by this: binary exponential backoff."""


class Prober:
    """Paces each picture; `now_s` never falls.

    If the link carries no more than the estimate, a picture sent faster delays the sound behind it,
    by up to 50 ms: a rare one, rarer after each fruitless probe, or every one while the rate is
    rising.
    """

    def __init__(self) -> None:
        self._climbs_until_s = 0.0
        self._next_s = 0.0
        self._pause_s = _FIRST_PAUSE_S

    def pace_bps(
        self, size_bytes: int, rate_bps: float, *, startup: bool, now_s: float
    ) -> tuple[float, bool]:
        """Return the pace, and whether the picture should be split into extra packets."""
        if rate_bps >= ENOUGH_BPS or size_bytes <= 0:
            return rate_bps, False
        bits = size_bytes * 8
        climbing = startup or now_s < self._climbs_until_s
        if not climbing and now_s < self._next_s:
            return rate_bps, False
        gain = _STARTUP_GAIN if startup else _PROBE_GAIN
        pace_bps = _fastest_bps(rate_bps, bits, _MAX_QUEUE_S, gain)
        if pace_bps < _MIN_GAIN * rate_bps:
            return rate_bps, False
        if not climbing:
            self._next_s = now_s + self._pause_s
            self._pause_s = min(_BACKOFF_FACTOR * self._pause_s, _MAX_PAUSE_S)
        return min(pace_bps, ENOUGH_BPS), True

    def risen(self, now_s: float) -> None:
        """Keep probing: the rate has risen."""
        self._climbs_until_s = now_s + _CLIMB_S
        self._next_s = now_s + _CLIMB_S
        self._pause_s = _FIRST_PAUSE_S

    def fallen(self, now_s: float) -> None:
        """Probe again soon, but not at once: the rate has fallen."""
        self._climbs_until_s = now_s
        self._next_s = now_s + _FIRST_PAUSE_S
        self._pause_s = _FIRST_PAUSE_S


def _fastest_bps(rate_bps: float, bits: int, queue_s: float, gain: float) -> float:
    """Return the pace that leaves a queue of `queue_s` on a link of exactly this rate."""
    slack_s = bits / rate_bps - queue_s
    if slack_s <= bits / (gain * rate_bps):
        return gain * rate_bps
    return bits / slack_s
