"""Statistics of one viewer's link during a visit, for the records."""

from __future__ import annotations

import math
from collections import Counter
from typing import TYPE_CHECKING, Final

from wax.records.entries import LinkSummary

if TYPE_CHECKING:
    from wax.session.viewer import Viewer


_STEP: Final = math.log(1.05)
"""Measurements are counted in steps of 5 %, which bounds the median's error."""
_LEAST: Final = 0.01
_MOST: Final = 1e9


class Spread:
    """Median and maximum of any number of measurements, in little memory.

    It counts those from 0 to `_MOST`; all others, NaN too, are ignored.
    """

    def __init__(self) -> None:
        self._counts: Counter[int | None] = Counter()
        self.worst: float | None = None

    def add(self, value: float | None) -> None:
        """Add a measurement; None is unknown."""
        if value is None or not 0 <= value <= _MOST:
            return
        self._counts[None if value < _LEAST else round(math.log(value) / _STEP)] += 1
        self.worst = value if self.worst is None else max(self.worst, value)

    @property
    def median(self) -> float | None:
        """The median, None without measurements."""
        half = (self._counts.total() + 1) // 2
        below = 0
        for step in sorted(self._counts, key=lambda one: -math.inf if one is None else one):
            below += self._counts[step]
            if below >= half:
                middle = 0.0 if step is None else math.exp(step * _STEP)
                return min(middle, self.worst or 0.0)
        return None


class LinkStatistics:
    """Call `sample` once a second."""

    def __init__(self) -> None:
        self._round_trip_ms = Spread()
        self._picture_age_ms = Spread()
        self._sound_age_ms = Spread()
        self._lost_percent = Spread()
        self._renditions: Counter[str] = Counter()

    def sample(self, viewer: Viewer) -> None:
        """Add what is known now; call it within the viewer's boundary."""
        newest_s, report = viewer.link.newest_s, viewer.report
        self._round_trip_ms.add(None if newest_s is None else newest_s * 1000)
        if report is not None:
            self._picture_age_ms.add(None if report.picture is None else report.picture.age_ms)
            self._sound_age_ms.add(None if report.sound is None else report.sound.age_ms)
        status = viewer.streams.status()
        self._lost_percent.add(None if status.lost is None else status.lost * 100)
        if status.served is not None and status.served.rendition is not None:
            self._renditions[status.served.rendition] += 1

    def summary(self) -> LinkSummary:
        longest = self._renditions.most_common(1)
        return LinkSummary(
            round_trip_ms=_rounded(self._round_trip_ms.median),
            round_trip_worst_ms=_rounded(self._round_trip_ms.worst),
            picture_age_ms=_rounded(self._picture_age_ms.median),
            picture_age_worst_ms=_rounded(self._picture_age_ms.worst),
            sound_age_ms=_rounded(self._sound_age_ms.median),
            sound_age_worst_ms=_rounded(self._sound_age_ms.worst),
            lost_percent=_rounded(self._lost_percent.median),
            lost_worst_percent=_rounded(self._lost_percent.worst),
            rendition=longest[0][0] if longest else None,
        )


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 1)
