"""How long to hold the picture back until its sound is heard, and from what skew not to wait."""

from __future__ import annotations

from collections import deque
from itertools import pairwise
from math import sqrt
from typing import Final

STEP_MS: Final = 10.0
"""What RTP's playout-delay can tell apart."""

_REPORT_S: Final = 0.25
"""How much time a report looks back on: the page sends one so often."""

_NEXT_PICTURE_S: Final = 0.02
"""A new hold-back has its effect from the next picture on: half of their distance."""

_SAMPLES: Final = 16
"""So many reports count at most, 4 s of them. Ours."""

_SURE_MS: Final = 8.0
"""A smaller error is what steps of 10 ms and the measurement leave. Ours."""

_UNSURE_MS: Final = 24.0
"""An error of so much is corrected after one report; it takes several to believe a smaller one.
Ours."""

_NOTICED_MS: Final = 125.0
"""Sound so late is noticed (ITU-R BT.1359): where even the longest hold-back would leave more, it
buys nothing, and the picture is shown at once. Thesis 3.3: delivery before synchronisation."""

_MET_AGAIN_MS: Final = 105.0
"""Below this it is held back again: hysteresis. Ours."""

_JUMP_MS: Final = 40.0
"""A report that differs by more must be confirmed by the next. Ours."""

_STOOD_MS: Final = 1000.0
"""A picture of which none younger was shown, and that is so old, stood: nothing came. Ours."""

_AT_ONCE_S: Final = 6.0
"""Thereafter pictures are shown at once for so long: Chromium's clock for them (its extrapolation
of time stamps, which an outage confuses) is right again after 150 pictures."""

_FARTHEST_MS: Final = 10_000.0
"""Nothing is farther from the sound; a bound against what cannot be."""


class HoldBack:
    """Tracks the skew without hold-back: the measured skew plus the hold-back at that time.

    So its own changes do not affect it, although reports show them only partly and a round trip
    later. The first report counts at once, a jump only after a second one confirms it. The mean
    covers as many reports as agree: browsers stretch sound by up to 75 ms a second.
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
        """Whether pictures are shown at once, because they stood until a moment ago."""
        return now_s < self._at_once_until_s

    @property
    def is_in_vain(self) -> bool:
        """Whether there is no hold-back because even the largest allowed would not be enough."""
        return self._in_vain

    def forget(self, held_ms: float, now_s: float) -> None:
        """Hold back by this from now on, and restart the measurement."""
        self._hold(held_ms, now_s)
        self._free.clear()
        self._doubted_ms = None

    def shown(self, age_ms: float | None, kept_ms: float | None, now_s: float) -> None:
        """Learn how old the picture on the screen is, and how long those since the last report
        were kept; None where there was none.

        After an outage a browser that is asked to keep pictures keeps them by a clock that is
        wrong by up to a second (thesis 3.3: delivery before synchronisation).
        """
        if kept_ms is None and age_ms is not None and age_ms > _STOOD_MS:
            self.forget(0.0, now_s)
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
                # Without hold-back a buffer keeps a few ms of its own, which count as part of a
                # hold-back.
                self._free.clear()

    @property
    def _wanted_ms(self) -> float:
        return sum(self._free) / len(self._free) - self._late_ms if self._free else 0.0

    def _hold(self, held_ms: float, now_s: float) -> None:
        held_ms = 0.0 if self.is_at_once(now_s) else self._bounded(held_ms)
        if held_ms != self.held_ms:
            self._history.append((now_s, held_ms))

    def _held_between(self, begin_s: float, end_s: float) -> float:
        """Return the mean hold-back; forget what was before."""
        while len(self._history) > 1 and self._history[1][0] <= begin_s:
            self._history.popleft()
        total = 0.0
        for (from_s, held_ms), (to_s, _) in pairwise([*self._history, (float("inf"), 0.0)]):
            total += held_ms * max(min(to_s, end_s) - max(from_s, begin_s), 0.0)
        return total / (end_s - begin_s) if end_s > begin_s else self.held_ms

    def _is_confirmed(self, free_ms: float) -> bool:
        """Add a measurement, unless it is the first one far from the others."""
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
    """Whether the newer half of the samples differs from the older half."""
    half = len(samples) // 2
    if half == 0:
        return False
    newer, older = samples[-half:], samples[:-half]
    return abs(sum(newer) / half - sum(older) / len(older)) > _UNSURE_MS / sqrt(half)
