"""Decides where one part of the tape ends and the next begins. Pure.

Decoding starts at a keyframe, so a part with pictures begins with one. None is requested for it,
because a keyframe costs every viewer. Without pictures parts begin by the clock.
"""

from __future__ import annotations

import math
from typing import Final, Literal

Kind = Literal["keyframe", "picture", "other"]
Step = Literal["begin", "write", "skip"]

_PATIENCE_S: Final = 2.0
"""The first part waits at most this long for its first keyframe."""
_SLACK_S: Final = 1.0
"""A keyframe may be this late before the part ends without one."""


class SegmentPlan:
    """Decides for each item, in order of arrival, whether to write or skip it or begin a part.

    A part lasts for `segment_s` and then until the next keyframe, one of which comes every
    `keyframe_interval_s`. Without a camera no part waits for a keyframe.
    """

    def __init__(self, *, segment_s: float, keyframe_interval_s: float, has_camera: bool) -> None:
        self._segment_s = segment_s
        self._longest_s = segment_s + keyframe_interval_s + _SLACK_S
        self._patience_s = _PATIENCE_S if has_camera else 0.0
        self._waits_since_s = math.inf
        self._began_s: float | None = None
        self._has_picture = False

    def decide(self, kind: Kind, at_s: float) -> Step:
        """Return the step for an item; "begin" starts a new part with it and ends the last one."""
        if self._is_due(kind, at_s):
            self._began_s, self._has_picture = at_s, kind == "keyframe"
            self._waits_since_s = math.inf
            return "begin"
        if self._began_s is None or (kind == "picture" and not self._has_picture):
            return "skip"
        return "write"

    def ended(self) -> None:
        """Record that the part has ended, so that the next begins as soon as possible."""
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
