"""Decides how long to hold the picture back for its sound, and when that is no use."""

from __future__ import annotations

from collections import deque
from itertools import pairwise
from math import sqrt
from typing import Final

STEP_MS: Final = 10.0
"""The resolution of RTP's playout-delay extension."""

_REPORT_S: Final = 0.25
"""The time that a report covers, which is also the interval between reports."""

_NEXT_PICTURE_S: Final = 0.02
"""A new hold-back takes effect with the next picture, on average half an interval later."""

_SAMPLES: Final = 16
"""The most reports in the mean, which cover 4 s. Ours."""

_SURE_MS: Final = 8.0
"""A smaller error is due to rounding to 10 ms and to the measurement. Ours."""

_UNSURE_MS: Final = 24.0
"""An error this large is corrected after one report; a smaller one takes several. Ours."""

_NOTICED_MS: Final = 125.0
"""Sound that is this late is noticed (ITU-R BT.1359). If even the longest hold-back leaves more, it
is no use, and the picture is shown at once. Thesis 3.3: delivery before synchronisation."""

_MET_AGAIN_MS: Final = 105.0
"""Below this the picture is held back again: hysteresis. Ours."""

_JUMP_MS: Final = 40.0
"""A report that differs by more must be confirmed by the next one. Ours."""

_STOOD_MS: Final = 1000.0
"""A picture that is older than this, and after which none was shown, has frozen. Ours."""

_AT_ONCE_S: Final = 6.0
"""After a freeze pictures are shown at once for this long: Chromium's extrapolation of time stamps,
which an outage confuses, recovers after 150 pictures."""

_FARTHEST_MS: Final = 10_000.0
"""The bound for a skew, against impossible reports."""


class HoldBack:
    """Estimates the skew without hold-back: the measured skew plus the hold-back at that time.

    So its own changes do not affect the estimate, although reports show them only partly and a
    round trip later. The first report counts at once, a jump only when a second one confirms it.
    The mean covers the reports that agree: browsers stretch sound by up to 75 ms a second.
    """

    def __init__(self, *, late_ms: float, max_ms: float, held_ms: float) -> None:
        """Tolerate sound `late_ms` late; hold back by at most `max_ms`, at first by `held_ms`."""
        self._late_ms = late_ms
        self._max_ms = max_ms
        self._in_vain = False
        self._history = deque([(float("-inf"), self._bounded(held_ms))])
        self._free: deque[float] = deque(maxlen=_SAMPLES)
        self._doubted_ms: float | None = None
        self._at_once_until_s = float("-inf")

    @property
    def held_ms(self) -> float:
        """The hold-back in ms, from 0 to the bound."""
        return self._history[-1][1]

    @property
    def is_short(self) -> bool:
        """Whether the bound limits the hold-back."""
        return self.held_ms >= self._max_ms and self._wanted_ms - self._max_ms >= _SURE_MS

    def is_at_once(self, now_s: float) -> bool:
        """Return whether pictures are shown at once after a recent freeze."""
        return now_s < self._at_once_until_s

    @property
    def is_in_vain(self) -> bool:
        """Whether nothing is held back because even the longest hold-back is no use."""
        return self._in_vain

    def restart(self, held_ms: float, now_s: float) -> None:
        """Hold back by `held_ms` from now on, and restart the measurement."""
        self._hold(held_ms, now_s)
        self._free.clear()
        self._doubted_ms = None

    def observe_picture(self, age_ms: float | None, kept_ms: float | None, now_s: float) -> None:
        """Show pictures at once for a while if the one on the screen, `age_ms` old, has frozen.

        `kept_ms` is how long pictures since the last report were buffered; None if there were none.
        After an outage a browser's buffer uses a clock that is wrong by up to a second (thesis 3.3:
        delivery before synchronisation).
        """
        if kept_ms is None and age_ms is not None and age_ms > _STOOD_MS:
            self.restart(0.0, now_s)
            self._at_once_until_s = now_s + _AT_ONCE_S

    def update(self, early_ms: float, round_trip_s: float, now_s: float) -> None:
        """Add a measurement of how much younger the picture is than the sound."""
        early_ms = min(max(early_ms, -_FARTHEST_MS), _FARTHEST_MS)
        end_s = now_s - round_trip_s - _NEXT_PICTURE_S
        if not self._is_confirmed(early_ms + self._held_between(end_s - _REPORT_S, end_s)):
            return
        error_ms = self._wanted_ms - self.held_ms
        if abs(error_ms) >= max(_SURE_MS, _UNSURE_MS / len(self._free)):
            was_ms = self.held_ms
            self._hold(self._wanted_ms, now_s)
            if was_ms == 0 != self.held_ms:
                # Without hold-back a buffer still keeps a few ms, which count as part of one.
                self._free.clear()

    @property
    def _wanted_ms(self) -> float:
        return sum(self._free) / len(self._free) - self._late_ms if self._free else 0.0

    def _hold(self, held_ms: float, now_s: float) -> None:
        held_ms = 0.0 if self.is_at_once(now_s) else self._bounded(held_ms)
        if held_ms != self.held_ms:
            self._history.append((now_s, held_ms))

    def _held_between(self, begin_s: float, end_s: float) -> float:
        """Return the mean hold-back between two times; drop older history."""
        while len(self._history) > 1 and self._history[1][0] <= begin_s:
            self._history.popleft()
        total = 0.0
        for (from_s, held_ms), (to_s, _) in pairwise([*self._history, (float("inf"), 0.0)]):
            total += held_ms * max(min(to_s, end_s) - max(from_s, begin_s), 0.0)
        return total / (end_s - begin_s) if end_s > begin_s else self.held_ms

    def _is_confirmed(self, free_ms: float) -> bool:
        """Add a measurement, unless it is an unconfirmed outlier; return whether it was added."""
        doubted_ms, self._doubted_ms = self._doubted_ms, None
        free = self._free
        if free and abs(free_ms - free[-1]) > _JUMP_MS:
            if doubted_ms is None or abs(free_ms - doubted_ms) > _JUMP_MS:
                self._doubted_ms = free_ms
                return False
            free.clear()
        free.append(free_ms)
        while _drifts(list(free)):
            free.popleft()
        return True

    def _bounded(self, ms: float) -> float:
        left_ms = ms + self._late_ms - self._max_ms
        self._in_vain = left_ms > (_MET_AGAIN_MS if self._in_vain else _NOTICED_MS)
        if self._in_vain:
            return 0.0
        return min(max(round(ms / STEP_MS) * STEP_MS, 0.0), self._max_ms)


def _drifts(samples: list[float]) -> bool:
    """Return whether the newer half of the samples differs from the older half."""
    half = len(samples) // 2
    if half == 0:
        return False
    newer, older = samples[-half:], samples[:-half]
    return abs(sum(newer) / half - sum(older) / len(older)) > _UNSURE_MS / sqrt(half)
