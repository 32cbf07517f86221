"""Where one part of the tape ends and the next begins. Pure.

Pictures can only be decoded from a keyframe on, so a part that has pictures begins with one; it
asks for none, since a keyframe costs every viewer. Without pictures parts begin by the clock.
"""

from __future__ import annotations

import math
from typing import Final, Literal

Kind = Literal["keyframe", "picture", "other"]
Step = Literal["begin", "write", "skip"]

_PATIENCE_S: Final = 2.0
"""So long the first part waits for its first keyframe."""
_SLACK_S: Final = 1.0
"""A keyframe may be so late before the part ends without."""


class SegmentPlan:
    """Decides for each item, in the order of arrival, what becomes of it.

    A part lasts `segment_s` and until the next keyframe, which come every `keyframe_interval_s`.
    Without a camera nothing waits for one.
    """

    def __init__(self, *, segment_s: float, keyframe_interval_s: float, has_camera: bool) -> None:
        self._segment_s = segment_s
        self._longest_s = segment_s + keyframe_interval_s + _SLACK_S
        self._patience_s = _PATIENCE_S if has_camera else 0.0
        self._waits_since_s = math.inf
        self._began_s: float | None = None
        self._has_picture = False

    def decide(self, kind: Kind, at_s: float) -> Step:
        """Return "begin" where a new part begins with this item, and ends the one before."""
        if self._is_due(kind, at_s):
            self._began_s, self._has_picture = at_s, kind == "keyframe"
            self._waits_since_s = math.inf
            return "begin"
        if self._began_s is None or (kind == "picture" and not self._has_picture):
            return "skip"
        return "write"

    def ended(self) -> None:
        """Note that the part has ended, so that the next begins as soon as it can."""
        self._began_s = None
        self._waits_since_s = math.inf

    def _is_due(self, kind: Kind, at_s: float) -> bool:
        if kind == "picture":
            return False
        if self._began_s is None:
            self._waits_since_s = min(self._waits_since_s, at_s)
            return kind == "keyframe" or at_s - self._waits_since_s >= self._patience_s
        age_s = at_s - self._began_s
        if kind == "keyframe":
            return not self._has_picture or age_s >= self._segment_s
        return age_s >= (self._longest_s if self._has_picture else self._segment_s)
