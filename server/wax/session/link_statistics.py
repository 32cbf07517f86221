"""Statistics of one viewer's link during a visit, for the records."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from wax.records.entries import LinkSummary
from wax.session.spread import Spread

if TYPE_CHECKING:
    from wax.session.viewer import Viewer


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
