"""Composes a picture of strips of the atlas, the nearest last (pure).

A strip writes where in the atlas its pixels are, and how bright. This costs far less than looking
up colours, and most pixels are covered several times, so colours are looked up when all is placed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import cv2
import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from wax.robot.simulated.atlas import Atlas


@dataclass(frozen=True, slots=True)
class Strip:
    """A surface in columns from `first`: rows `top` to `bottom` of each column, where `seen`.

    Column `c` shows column `u[c]` of the atlas, from row `v` on, `slope[c]` atlas rows for each row
    of the picture, `shade` of its brightness.
    """

    first: int
    top: NDArray[np.float32]
    bottom: NDArray[np.float32]
    seen: NDArray[np.bool_]
    u: NDArray[np.float32]
    v: NDArray[np.float32] | float
    slope: NDArray[np.float32]
    shade: NDArray[np.float32]


class Lookup:
    """The coordinates of pictures of one size; keeps its buffers, so it belongs to one thread."""

    def __init__(self, atlas: Atlas, width: int, height: int) -> None:
        self._atlas = atlas
        self._height = height
        self.rows = (np.arange(height, dtype=np.float32) + 0.5)[:, None]
        shape = (height, width)
        self.u, self.v = np.empty(shape, np.float32), np.empty(shape, np.float32)
        self.shade = np.empty(shape, np.uint8)
        self._numbers = np.arange(height, dtype=np.int16)[:, None]
        self._v = np.empty(shape, np.float32)
        self._from_top = np.empty(shape, np.int16)
        self._inside = np.empty(shape, np.bool_)
        self._colours = np.empty((*shape, 4), np.uint8)
        self._shades, self._frame = np.empty((*shape, 3), np.uint8), np.empty((*shape, 3), np.uint8)

    def put(self, strip: Strip, *, has_holes: bool = False) -> None:
        """Cover what was there; with `has_holes` it shows where the atlas is transparent."""
        top, bottom = (self._rows_above(edge) for edge in (strip.top, strip.bottom))
        tall = np.where(strip.seen, bottom - top, 0)
        low, high = int(top[strip.seen].min()), int(bottom[strip.seen].max())
        if low >= high:
            return
        area = np.s_[low:high, strip.first : strip.first + len(top)]
        rows, v, inside = self.rows[low:high], self._v[area], self._inside[area]
        # As an unsigned number, a row above the top is larger than any height.
        from_top = np.subtract(self._numbers[low:high], top, out=self._from_top[area])
        np.less(from_top.view(np.uint16), tall.astype(np.uint16), out=inside)
        np.multiply(rows, strip.slope, out=v)
        v += strip.v - strip.top * strip.slope
        u = cv2.repeat(strip.u[None], high - low, 1)
        mask = inside.view(np.uint8)
        if has_holes:
            alpha = np.asarray(cv2.remap(self._atlas.alpha, u, v, cv2.INTER_LINEAR), np.uint8)
            mask &= alpha >> 7
        shade = np.minimum(255.0, 255.0 * strip.shade).astype(np.uint8)
        cv2.copyTo(u, mask, self.u[area])
        cv2.copyTo(v, mask, self.v[area])
        cv2.copyTo(cv2.repeat(shade[None], high - low, 1), mask, self.shade[area])

    def picture(self) -> NDArray[np.uint8]:
        """Look up all colours; the array ``(height, width, 3)`` is overwritten by the next call."""
        cv2.remap(self._atlas.image, self.u, self.v, cv2.INTER_LINEAR, dst=self._colours)
        cv2.cvtColor(self._colours, cv2.COLOR_BGRA2BGR, dst=self._frame)
        cv2.cvtColor(self.shade, cv2.COLOR_GRAY2BGR, dst=self._shades)
        cv2.multiply(self._frame, self._shades, dst=self._frame, scale=1.0 / 255.0)
        return self._frame

    def _rows_above(self, edge: NDArray[np.float32]) -> NDArray[np.int16]:
        """Return how many rows of the picture have their middle above this edge, by column."""
        rows = np.ceil(np.clip(edge - np.float32(0.5), 0.0, self._height))
        return np.asarray(rows, np.int16)
