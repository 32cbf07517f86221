"""The extra roll-back for a client with a longer audio buffer (thesis 5.3.1).

Java 1.1 buffered 50 ms of sound, Java 2 256 ms, so that the sound played 200 ms after the picture.
The thesis rolls the video back by as much; here the browser's reports decide by how much.
"""

from __future__ import annotations

from collections import deque
from statistics import median
from typing import TYPE_CHECKING, Final, Literal

if TYPE_CHECKING:
    from wax.config.thesis import ThesisSettings
    from wax.sync.playout import PlayoutReport

Measure = Literal["ages", "buffers"]

_REPORTS: Final = 5
"""The number of reports in the median; a page sends four a second."""

_SETTLE_S: Final = 1.0
"""The earliest time at which reports show the effect of a change."""


class Compensation:
    """Turns reports into the extra roll-back; changes it only once the last change shows."""

    def __init__(self, settings: ThesisSettings) -> None:
        self._settings = settings
        self._missing_ms: deque[float] = deque(maxlen=_REPORTS)
        self._measure: Measure | None = None
        self._settled_s = 0.0
        self.extra_s = 0.0

    def reported(self, report: PlayoutReport, rollback_s: float | None, now_s: float) -> float:
        """Handle a report; return the extra roll-back in seconds, 0 to `max_extra_rollback_ms`.

        `rollback_s` is the virtual clock's present roll-back, None while nothing is synchronised:
        reports then reveal nothing about the client. An error within half a video MU changes
        nothing, since each picture lasts for a whole one.
        """
        if rollback_s is None or now_s < self._settled_s:
            self._missing_ms.clear()
            return self.extra_s
        found = self._missing(report)
        if found is None:
            return self.extra_s
        measure, missing_ms = found
        if measure != self._measure:
            # The two measures are not comparable, so a median must not mix them.
            self._measure = measure
            self._missing_ms.clear()
        self._missing_ms.append(missing_ms)
        believed_ms = median(self._missing_ms)
        if len(self._missing_ms) < _REPORTS or abs(believed_ms) <= self._settings.video_mu_ms / 2:
            return self.extra_s
        longest_s = self._settings.max_extra_rollback_ms / 1000
        moved_s = min(max(self.extra_s + believed_ms / 1000, 0.0), longest_s)
        if moved_s != self.extra_s:
            self._settled_s = now_s + rollback_s + abs(moved_s - self.extra_s) + _SETTLE_S
            self._missing_ms.clear()
        self.extra_s = moved_s
        return self.extra_s

    def _missing(self, report: PlayoutReport) -> tuple[Measure, float] | None:
        """Return the measure and by how many ms the picture is still too early; None if unknown.

        Known ages count first, as they include the whole path. Otherwise the sound's buffer counts:
        a burst of one audio MU stays there for half its length on average, as in the thesis's
        queue, and the reference client's 50 ms are expected.
        """
        sound, picture = report.sound, report.picture
        if sound is None or picture is None:
            return None
        if sound.age_ms is not None and picture.age_ms is not None:
            return "ages", sound.age_ms - picture.age_ms
        if sound.delay_ms is None or picture.delay_ms is None:
            return None
        usual_ms = self._settings.audio_mu_ms / 2 + self._settings.reference_audio_buffer_ms
        return "buffers", sound.delay_ms - usual_ms - picture.delay_ms - self.extra_s * 1000
