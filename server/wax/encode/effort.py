"""How much effort the processor's encoder makes for a picture. Pure."""

from __future__ import annotations

from typing import Final

_HURRIES_SHARE: Final = 0.5
"""Of the frame interval, on the mean. From here on bursts of other work make pictures late."""
_CALM_SHARE: Final = 0.15
"""A hurried encoder takes half of the time, so a thorough one will take twice this."""
_CALM_PICTURES: Final = 300
"""Ten seconds: a machine that is free for a moment is busy again soon."""
_WEIGHT: Final = 0.05


class Effort:
    """Whether a machine is too slow, or too busy, for thorough encoding.

    Hurried pictures are a little less sharp, but in time; the size stays.
    """

    def __init__(self, fps: float) -> None:
        self._fps = fps
        self._share = 0.0
        self._pictures = 0
        self.is_hurried = False

    def took(self, encode_s: float) -> None:
        """Count a picture that is no keyframe, which takes longer, and by which nobody is late."""
        self._pictures += 1
        self._share += _WEIGHT * (encode_s * self._fps - self._share)

    def changes(self, *, keyframe: bool) -> bool:
        """Decide anew; return whether the effort changes, which takes a new encoder.

        That begins with a keyframe, so one is spent on hurrying at once, but none on sharpness.
        """
        is_hurried = self._share > _HURRIES_SHARE
        if self.is_hurried:
            is_calm = self._share < _CALM_SHARE and self._pictures >= _CALM_PICTURES
            is_hurried = not (keyframe and is_calm)
        if is_hurried == self.is_hurried:
            return False
        self.is_hurried = is_hurried
        self._share, self._pictures = 0.0, 0
        return True
