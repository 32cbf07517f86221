"""The conditions of a direction over time, constant between changes."""

from __future__ import annotations

import math
from bisect import bisect_right
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tests.link.profile import Conditions, DirectionSettings


class Schedule:
    """Until `start` the first conditions apply; then the changes follow at their times."""

    def __init__(self, settings: DirectionSettings) -> None:
        self._steps = settings.steps()
        self._from_s = [-math.inf] + [math.inf] * (len(self._steps) - 1)

    def start(self, now_s: float) -> None:
        """Count the times of the changes from now on; may be called again."""
        self._from_s = [-math.inf, *(now_s + at_s for at_s, _ in self._steps[1:])]

    def at(self, time_s: float) -> Conditions:
        return self._steps[bisect_right(self._from_s, time_s) - 1][1]

    def change_after_s(self, time_s: float) -> float:
        """Return when the conditions at `time_s` end; infinite if they never do."""
        index = bisect_right(self._from_s, time_s)
        return self._from_s[index] if index < len(self._from_s) else math.inf
