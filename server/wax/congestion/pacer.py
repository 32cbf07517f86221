"""When and how fast to send each picture, so that it probes the link but hardly delays sound."""

from __future__ import annotations

import math
from typing import Final

_MAX_DEBT_S: Final = 10.0
"""Maximum debt: after this long every packet has arrived or is lost."""
STARTING_RATE_BPS: Final = 300_000.0
"""Assumed rate before any feedback, as in libwebrtc."""
ENOUGH_BPS: Final = 20_000_000.0
"""Highest rate: ten times that of the largest rendition."""
_STARTUP_GAIN: Final = 4.0
"""Pacing gain of a probe at startup. libwebrtc: 3 and 6; BBR's Startup: 2.77."""
_PROBE_GAIN: Final = 2.0
"""Pacing gain of a probe afterwards. libwebrtc: 2; BBR's ProbeBW_UP: 1.25."""
_MAX_QUEUE_S: Final = 0.050
"""The queue a probe may build: a jitter buffer absorbs it inaudibly. As NADA's QTH (RFC 8698)."""
_CLIMB_S: Final = 1.0
"""For this long after a rise, every picture is a probe."""
_FIRST_PAUSE_S: Final = 1.0
"""Pause between the first two probes that find nothing."""
_MAX_PAUSE_S: Final = 30.0
"""Longest pause; each probe that finds nothing doubles it. libwebrtc probes every 5 s if the
application limits the rate, BBR every 2 to 3 s; our probes delay sound, so they are rarer."""


def gap_s(size_bytes: int, pace_bps: float) -> float:
    """Return the gap between a datagram of `size_bytes` and the next one of its train."""
    return size_bytes * 8 / pace_bps


class Pacer:
    """A leaky bucket that says when the link is free again; a `now_s` that falls frees nothing.

    Sound is counted but never waits, so pictures give way to it. The debt is in bits, so that it
    takes longer to drain when the rate falls.
    """

    def __init__(self, rate_bps: float) -> None:
        self.rate_bps = rate_bps
        self._owed_bits = 0.0
        self._measured_bits = 0.0
        self._now_s = -math.inf

    def spend(self, size_bytes: int, now_s: float) -> None:
        self._pass(now_s)
        most_bits = _MAX_DEBT_S * self.rate_bps
        self._owed_bits = min(self._owed_bits + size_bytes * 8, most_bits)
        self._measured_bits = min(self._measured_bits + size_bytes * 8, most_bits)

    def drain(self, queue_ms: float, now_s: float) -> None:
        """Replace the measured queue of the link, 0 to 10 s."""
        self._pass(now_s)
        self._measured_bits = queue_ms / 1000 * self.rate_bps

    def forgive(self) -> None:
        """Forget a debt that no queue confirms: the rate was wrong."""
        self._owed_bits = min(self._owed_bits, self._measured_bits)

    def free_in_s(self, now_s: float) -> float:
        self._pass(now_s)
        # The larger debt counts, since both contain the same datagrams.
        return max(self._owed_bits, self._measured_bits) / self.rate_bps

    def _pass(self, now_s: float) -> None:
        if now_s > self._now_s:
            paid_bits = (now_s - self._now_s) * self.rate_bps
            self._owed_bits = max(0.0, self._owed_bits - paid_bits)
            self._measured_bits = max(0.0, self._measured_bits - paid_bits)
            self._now_s = now_s


class Prober:
    """Paces each picture: rarely above the rate, because a failed probe delays the sound."""

    def __init__(self) -> None:
        self._climbs_until_s = 0.0
        self._next_s = 0.0
        self._pause_s = _FIRST_PAUSE_S

    def pace_bps(self, size_bytes: int, rate_bps: float, *, startup: bool, now_s: float) -> float:
        """Return the pace for a picture of this size; a pace above `rate_bps` is a probe."""
        climbing = startup or now_s < self._climbs_until_s
        if rate_bps >= ENOUGH_BPS or size_bytes <= 0 or not (climbing or now_s >= self._next_s):
            return rate_bps
        pace_bps = (_STARTUP_GAIN if startup else _PROBE_GAIN) * rate_bps
        bits = size_bytes * 8
        leaves_in_s = bits / rate_bps - _MAX_QUEUE_S
        if leaves_in_s > 0:  # on a link of exactly this rate
            pace_bps = min(pace_bps, bits / leaves_in_s)
        if not climbing:
            self._next_s = now_s + self._pause_s
            self._pause_s = min(2 * self._pause_s, _MAX_PAUSE_S)
        return min(pace_bps, ENOUGH_BPS)

    def changed(self, now_s: float, *, has_risen: bool) -> None:
        """Keep probing after the rate has risen; after a fall probe again soon, but not at once."""
        self._climbs_until_s = now_s + _CLIMB_S if has_risen else now_s
        self._next_s = now_s + _FIRST_PAUSE_S
        self._pause_s = _FIRST_PAUSE_S
