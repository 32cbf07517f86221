"""How near the presented picture is to the source: SSIM and PSNR of what stands on the page.

A page is looked at in even steps, so a picture counts for as long as it stands. What stands there
is enlarged to the source's size as a browser does it, bilinearly, and compared with the test card
below its cells: the moving texture, or the film. A fresh picture is compared with the card of its
own stamp, since this is about blur, and age has figures of its own. A picture that stands for
longer than `FROZEN_MS`, or whose stamp cannot be read any more, is compared with the card of the
moment of the look: what is seen is not what is there.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, NamedTuple

import cv2
import numpy as np
from tests.capture.card_reader import read_stamp

from e2e.instrument.stamps import whole_ms
from wax.capture.testcard import ROWS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from e2e.delay.readings import Pictures
    from e2e.peers.sizes import Size

FROZEN_MS: Final = 200.0
_WINDOW: Final = ((11, 11), 1.5)
_C1: Final = (0.01 * 255) ** 2
_C2: Final = (0.03 * 255) ** 2
_LEAST_ERROR: Final = 1 / 12
"""The mean square of rounding to whole greys, which bounds the PSNR of equal pictures."""


class Look(NamedTuple):
    """The luma that stands on the page at a moment, Unix ms."""

    at_ms: float
    luma: NDArray[np.uint8]


def sharpness(looks: Sequence[Look], pictures: Pictures, size: Size) -> dict[str, float]:
    """Return the figures, means over the looks, for a source of this size.

    `pictures` tell since when a picture stands. Without looks there is no figure.
    """
    if not looks:
        return {}
    since_ms: dict[float | None, float] = {}
    for stamp_ms, at_ms in zip(pictures.stamp_ms, pictures.at_ms, strict=True):
        since_ms.setdefault(stamp_ms, at_ms)
    card = size.camera()
    card.open()
    below = ROWS * size.height // 15
    pairs = []
    for at_ms, luma in looks:
        stamp40_ms = read_stamp(luma)
        own_ms = None if stamp40_ms is None else whole_ms(stamp40_ms, at_ms)
        is_fresh = own_ms is not None and at_ms - since_ms.get(own_ms, at_ms) <= FROZEN_MS
        source = card.draw(math.floor(own_ms if own_ms is not None and is_fresh else at_ms))
        seen = cv2.resize(luma, size[:2], interpolation=cv2.INTER_LINEAR)
        pairs.append((source[below : size.height], seen[below:].astype(np.uint8)))
    error = np.mean([_mean_square(*pair) for pair in pairs])
    return {
        "sharpness_ssim": float(np.mean([ssim(*pair) for pair in pairs])),
        "sharpness_psnr_db": 10 * math.log10(255**2 / max(float(error), _LEAST_ERROR)),
    }


def ssim(one: NDArray[np.uint8], two: NDArray[np.uint8]) -> float:
    """Return the structural similarity of two pictures of one size, 1 if they are equal.

    As its authors define it (Wang et al., 2004), with a Gaussian window of 11 × 11 and σ = 1.5.
    """
    x, y = one.astype(np.float32), two.astype(np.float32)
    mean_x, mean_y, xx, yy, xy = (
        cv2.GaussianBlur(part, *_WINDOW) for part in (x, y, x * x, y * y, x * y)
    )
    both = mean_x * mean_y
    squares = mean_x * mean_x + mean_y * mean_y
    likeness = (2 * both + _C1) * (2 * (xy - both) + _C2)
    return float(np.mean(likeness / ((squares + _C1) * (xx + yy - squares + _C2))))


def _mean_square(one: NDArray[np.uint8], two: NDArray[np.uint8]) -> float:
    return float(np.mean(np.square(one.astype(np.float32) - two)))
