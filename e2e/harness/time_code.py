"""A camera that films the time code of `wax glass` late, askew, dim and noisy; and its reading.

It draws the code from what `web/src/glass/code.ts` says of it, not by the page's own code. For a
configuration: ``source = "e2e.harness.time_code:Late40"``.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Final

import cv2
import numpy as np

from wax.capture.source import Picture

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from wax.clock import Clock
    from wax.config.video import VideoSettings

WIDTH: Final = 36
HEIGHT: Final = 22
MARGIN: Final = 2
PERIOD_MS: Final = 256
_SCALE: Final = 8
_CELLS: Final = [(top, at) for top in (0, 15) for at in range(20)]


def draw(ms: float) -> NDArray[np.uint8]:
    """Return the code of this time with its margin, black on white, `_SCALE` pixels a module."""
    card = np.full(((HEIGHT + 2 * MARGIN) * _SCALE, (WIDTH + 2 * MARGIN) * _SCALE), 255, np.uint8)

    def fill(left: float, top: float, width: float, height: float, grey: int = 0) -> None:
        x, y = round((left + MARGIN) * _SCALE), round((top + MARGIN) * _SCALE)
        card[y : y + round(height * _SCALE), x : x + round(width * _SCALE)] = grey

    period, within_ms = divmod(ms, PERIOD_MS)
    edge = 2 + 32 * within_ms / PERIOD_MS
    fill(edge, 8, WIDTH - edge, 6)
    for left in (0, WIDTH - 7):
        for top in (0, HEIGHT - 7):
            for inset, grey in ((0, 0), (1, 255), (2, 0)):
                fill(left + inset, top + inset, 7 - 2 * inset, 7 - 2 * inset, grey)
    bits = _bits(int(period) % 256)
    for top, at in _CELLS:
        if not bits[at]:
            fill(8 + 2 * (at % 10), top + 3.5 * (at // 10), 2, 3.5)
    return card


def read_straight(grey: NDArray[np.uint8]) -> float | None:
    """Return the time that a picture of nothing but the code shows; None while it changes."""
    height, width = grey.shape
    module = min(width / (WIDTH + 2 * MARGIN), height / (HEIGHT + 2 * MARGIN))
    left, top = (width - module * WIDTH) / 2, (height - module * HEIGHT) / 2

    def is_white(x: float, y: float) -> bool:
        return bool(grey[int(top + y * module), int(left + x * module)] > 127)

    white = sum(is_white(x / 10, 11) for x in range(WIDTH * 10)) / 10
    cells = [is_white(9 + 2 * (at % 10), row + 1.75 + 3.5 * (at // 10)) for row, at in _CELLS]
    number = next((one for one in range(256) if _bits(one) * 2 == cells), None)
    return None if number is None else (number + (white - 2) / 32) * PERIOD_MS


def _bits(number: int) -> list[bool]:
    """Return eight bits and their CRC-12 (0x80F), which is inverted by 0xA5C."""
    rest = number << 12
    for at in range(19, 11, -1):
        if rest >> at & 1:
            rest ^= 0x180F << at - 12
    return [bool((number << 12 | rest ^ 0xA5C) >> at & 1) for at in range(19, -1, -1)]


class FilmedCode:
    """Shows how the code looked `late_s` ago, as if it were captured now."""

    late_s = 0.0

    def __init__(self, settings: VideoSettings, clock: Clock) -> None:
        self._size = settings.upright_size
        self._fps = settings.fps
        self._clock = clock
        self._random = np.random.default_rng(5)
        self._next_s = 0.0
        self._count = 0

    def open(self) -> None:
        self._next_s = self._clock.now_s()

    def read(self) -> Picture:
        now_s = self._clock.now_s()
        self._next_s = max(self._next_s + 1 / self._fps, now_s)
        time.sleep(self._next_s - now_s)
        captured_s = self._clock.now_s()
        seen = self._filmed(draw((captured_s - self.late_s) * 1000))
        return Picture.from_bgr(np.dstack([seen] * 3), captured_s, within_s=0.0)

    def close(self) -> None:
        """Do nothing: there is nothing to release."""

    def _filmed(self, card: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Turn, tilt, mirror, cover and darken it, each picture otherwise, and add noise."""
        self._count += 1
        width, height = self._size
        if self._count // 20 % 2:
            card = card[:, ::-1]
        down, across = card.shape
        if self._count // 10 % 2:
            card = card.copy()
            card[: down // 3, across // 3 : across // 2] = 90  # some of the upper cells
        angle = self._count / 15
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        half = height * 0.3 * np.array([across / down, 1])
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
        corners = (corners * [[0.9], [1.0], [1.0], [0.95]]) @ turn.T + [width / 2, height / 2]
        source = np.array([[0, 0], [across, 0], [across, down], [0, down]], np.float32)
        seen = cv2.warpPerspective(
            card,
            cv2.getPerspectiveTransform(source, corners.astype(np.float32)),
            (width, height),
            flags=cv2.INTER_AREA,
            borderValue=130,
        )
        noise = self._random.normal(20, 4, seen.shape)
        dim: NDArray[np.uint8] = np.clip(seen * 0.45 + noise, 0, 255).astype(np.uint8)
        return dim


class Late40(FilmedCode):
    late_s = 0.040


class Late120(FilmedCode):
    late_s = 0.120
