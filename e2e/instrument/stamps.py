"""The test card's stamp, 40 bits, as a whole Unix time."""

from __future__ import annotations

import math
from typing import Final

from wax.capture.testcard import STAMP_MODULUS

_PLAUSIBLE_MS: Final = 600_000.0
"""A card farther from now is invalid: one picture in 256 has the right check by chance."""


def whole_ms(stamp40_ms: int, at_ms: float) -> float | None:
    """Return the Unix time near `at_ms` that a card's 40 bits stand for; None if none is near."""
    half = STAMP_MODULUS // 2
    behind_ms = (math.floor(at_ms) - stamp40_ms + half) % STAMP_MODULUS - half
    return None if abs(behind_ms) > _PLAUSIBLE_MS else float(math.floor(at_ms) - behind_ms)
