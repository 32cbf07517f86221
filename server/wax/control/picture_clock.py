"""Whose word the age of the driving view is: known within so much, or nobody's. Pure.

A source says with each picture within what its time of capture is right, or nothing
(`wax.capture.source.Picture`). By a picture of which nobody can say how old it is, nobody drives.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, Self

_DOUBT_S: Final = 3.0
"""A stream that has just been opened is not known either, and soon will be."""


@dataclass(frozen=True, slots=True)
class PictureClock:
    """Pictures captured at `since_s` or later are known, within `within_s`; infinite: none is.

    `doubted_s` is when the first of those was captured that are not known, None if they are.
    """

    since_s: float = math.inf
    within_s: float = 0.0
    doubted_s: float | None = None

    def after(self, captured_s: float, within_s: float | None) -> Self:
        """Return it after one more picture; an error that is no number is an unknown one."""
        if within_s is None or not 0.0 <= within_s < math.inf:
            doubted_s = captured_s if self.doubted_s is None else self.doubted_s
            return type(self)(doubted_s=doubted_s)
        if not self.since_s < math.inf:
            return type(self)(captured_s, within_s)
        # The screen may still show the one that is known less exactly.
        return type(self)(self.since_s, max(self.within_s, within_s))

    def is_doubted(self, now_s: float) -> bool:
        """Whether pictures have come for a while of which nobody knows how old they are."""
        return self.doubted_s is not None and now_s - self.doubted_s > _DOUBT_S
