"""How well the age of the driving picture is known: within an error bound, or not at all. Pure.

A source gives each picture's capture time with an error bound, or with None if it knows none
(`wax.capture.source.Picture`). Nobody may drive by a picture of unknown age.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, Self

_DOUBT_S: Final = 3.0
"""A stream that has just been opened does not know its clock yet, but soon will."""


@dataclass(frozen=True, slots=True)
class PictureClock:
    """The age of pictures captured from `since_s` on is known within `within_s`.

    An infinite `since_s` means that no picture's age is known. `doubted_s` is when the first
    picture of unknown age was captured, None while ages are known.
    """

    since_s: float = math.inf
    within_s: float = 0.0
    doubted_s: float | None = None

    def after(self, captured_s: float, within_s: float | None) -> Self:
        """Return the clock after one more picture; an infinite or NaN error means unknown."""
        if within_s is None or not 0.0 <= within_s < math.inf:
            doubted_s = captured_s if self.doubted_s is None else self.doubted_s
            return type(self)(doubted_s=doubted_s)
        if not self.since_s < math.inf:
            return type(self)(captured_s, within_s)
        # The screen may still show an earlier picture, known less exactly.
        return type(self)(self.since_s, max(self.within_s, within_s))

    def is_doubted(self, now_s: float) -> bool:
        """Whether pictures of unknown age have been arriving for more than `_DOUBT_S`."""
        return self.doubted_s is not None and now_s - self.doubted_s > _DOUBT_S
