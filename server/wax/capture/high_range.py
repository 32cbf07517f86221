"""Converts HDR pictures (ITU-R BT.2100: PQ and HLG) for an ordinary (SDR) screen.

Light of 203 cd/m² becomes white (ITU-R BT.2408, table 1), and brighter light is clipped. libswscale
can convert them, too, but takes seconds before its first picture.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Final

import cv2
import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

PQ: Final = 16
HLG: Final = 18
"""Transfer characteristics of ITU-T H.273, table 3."""

_WHITE_NITS: Final = 203.0
_HLG_NITS: Final = 1000.0
_GAMMA: Final = 2.4
"""A screen's gamma (ITU-R BT.1886)."""
_TO_709: Final = np.array(
    [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]],
    np.float32,
)
"""Converts primaries of BT.2020 to those of BT.709 (ITU-R BT.2407, 2.2)."""
_STEPS: Final = 4096


def to_sdr(rgb: NDArray[np.uint16], transfer: int) -> NDArray[np.uint8]:
    """Convert 16 bit RGB of this transfer, ``(height, width, 3)``, to 8 bit RGB of BT.709."""
    light = cv2.transform(_light(transfer).take(rgb >> 4), _TO_709)
    return _coded().take((np.clip(light, 0, 1) * (_STEPS - 1)).astype(np.uint16))


@cache
def _light(transfer: int) -> NDArray[np.float32]:
    """Return the light of each of 4096 steps; white is 1 (BT.2100, tables 4 and 5)."""
    step = np.arange(_STEPS) / (_STEPS - 1)
    if transfer == PQ:
        root = step ** (1 / 78.84375)
        nits = 10_000 * (np.maximum(root - 0.8359375, 0) / (18.8515625 - 18.6875 * root)) ** (
            1 / 0.1593017578125
        )
    else:
        scene = np.where(
            step <= 0.5, step**2 / 3, (np.exp((step - 0.55991073) / 0.17883277) + 0.28466892) / 12
        )
        nits = _HLG_NITS * scene**1.2
    return (nits / _WHITE_NITS).astype(np.float32)


@cache
def _coded() -> NDArray[np.uint8]:
    step = np.arange(_STEPS) / (_STEPS - 1)
    return (255 * step ** (1 / _GAMMA)).round().astype(np.uint8)
