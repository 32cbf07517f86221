"""The test card: picture and sound carry their own time, so that delay can be measured.

Picture: 48 cells in 3 rows of 16 over the top fifth, row by row, each width/16 × height/15, white
is 1: 40 bits of the Unix time of capture in ms (modulo 2⁴⁰), the most significant first, then
CRC-8 (polynomial 0x07, start 0) of these five bytes. Below: moving texture, the clock in digits.

Sound: a constant 300 Hz, so that gaps can be heard and measured, and 100 ms of 1 kHz at each whole
Unix second.
"""

from __future__ import annotations

import math
import time
from functools import cache
from typing import TYPE_CHECKING, Final

import cv2
import numpy as np

from wax.capture.letterbox import planes
from wax.capture.source import BLOCK_SAMPLES, REST_S, SAMPLE_RATE_HZ, Picture, Sound
from wax.capture.timestamp_overlay import draw_text, wall_text

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from wax.clock import Clock
    from wax.config.audio import AudioSettings
    from wax.config.video import VideoSettings

COLUMNS: Final = 16
ROWS: Final = 3
STAMP_MODULUS: Final = 1 << 40

_WHITE: Final = 235
_BLACK: Final = 16
_MIDDLE: Final = (_WHITE + _BLACK) / 2

_TONE_HZ: Final = 300
_TONE_AMPLITUDE: Final = 0.05
_BURST_HZ: Final = 1000
_BURST_AMPLITUDE: Final = 0.4
_BURST_SAMPLES: Final = SAMPLE_RATE_HZ // 10
_LATE_S: Final = 0.2
"""Sound later than this (the machine slept) is dropped, not sent all at once."""
_BURST_LATE_S: Final = 0.0011
"""A burst may begin this late: the estimate of the wall clock moves by up to 1 ms."""


def crc8(data: bytes) -> int:
    """CRC-8, polynomial 0x07, start 0, not reflected."""
    crc = 0
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = (crc << 1 ^ (0x07 if crc & 0x80 else 0)) & 0xFF
    return crc


class TestCardVideo:
    """The picture, at the size and rate of the settings; never turned or mirrored.

    A turned picture's cells could not be read.
    """

    is_upright: Final = True
    rest_s: Final = REST_S
    __test__ = False  # keeps pytest from collecting it by its name

    def __init__(
        self, settings: VideoSettings, clock: Clock, *, sleep: Callable[[float], None] = time.sleep
    ) -> None:
        self.width, self.height = settings.upright_size
        self._fps = settings.fps
        self._clock = clock
        self._sleep = sleep
        self._start_s = 0.0
        self._frame = 0
        self._tile: NDArray[np.uint8] | None = None

    def open(self) -> None:
        self._tile = _texture(self.width, self.height)
        self._start_s = self._clock.now_s()
        self._frame = 0

    def read(self) -> Picture:
        """Wait for the next frame's time, skipping frames whose time has passed."""
        late = (self._clock.now_s() - self._start_s) * self._fps
        self._frame = max(self._frame, math.floor(late))
        _sleep_until(self._start_s + self._frame / self._fps, self._clock, self._sleep)
        captured_s, wall_ms = self._clock.now_s(), self._clock.wall_ms()
        picture = Picture(self.draw(wall_ms), captured_s, within_s=0.0)
        self._frame += 1
        return picture

    def close(self) -> None:
        self._tile = None

    def draw(self, wall_ms: int) -> NDArray[np.uint8]:
        """Return the card of this moment, which depends on nothing else: I420, when opened."""
        i420 = self.paint(wall_ms)
        luma, *chroma = planes(i420)
        top = ROWS * self.height // 15
        luma[:top] = _cells(wall_ms, self.width, top)
        for plane in chroma:
            plane[: top // 2 + 1] = 128
        return i420

    def paint(self, wall_ms: int) -> NDArray[np.uint8]:
        """Return what is below the cells, and anything under them."""
        if self._tile is None:
            raise RuntimeError("read before open")
        width, height, tile = self.width, self.height, self._tile
        i420 = np.empty((height * 3 // 2, width), np.uint8)
        luma, *chroma = planes(i420)
        # Two layers that drift apart: no motion vector describes their sum, so the encoder works.
        first = _window(tile, wall_ms // 17, wall_ms // 41, width, height)
        second = _window(tile, -wall_ms // 29, wall_ms // 13, width, height)
        cv2.addWeighted(first, 0.5, second, 0.5, 0.0, dst=luma)
        chroma[0][:] = _window(tile, wall_ms // 23, 0, width // 2, height // 2)
        chroma[1][:] = _window(tile, 0, -wall_ms // 31, width // 2, height // 2)
        self._draw_bars(luma[height * 2 // 5 :], wall_ms)
        draw_text(luma, wall_text(wall_ms), bottom=height * 2 // 3)
        return i420

    def _draw_bars(self, luma: NDArray[np.uint8], wall_ms: int) -> None:
        """Draw a white and a dark bar that cross the picture in 4 and 3 s."""
        bar = max(2, self.width // 40)
        for grey, period_ms in ((_WHITE, 4000), (_BLACK, 3000)):
            left = wall_ms % period_ms * (self.width - bar) // period_ms
            luma[:, left : left + bar] = grey


class TestCardAudio:
    """The sound, in blocks of 10 ms, each delivered when its last sample is due.

    Samples follow the monotonic clock without drift; bursts follow the wall clock to within 1 ms,
    even after the wall clock was set.
    """

    rest_s: Final = REST_S
    __test__ = False

    def __init__(
        self, settings: AudioSettings, clock: Clock, *, sleep: Callable[[float], None] = time.sleep
    ) -> None:
        del settings  # its keys are about the encoding
        self._clock = clock
        self._sleep = sleep
        self._start_s = 0.0
        self._sample = 0
        self._offset_s = 0.0
        self._next_second = 0
        self._burst_sample = _BURST_SAMPLES

    def open(self) -> None:
        self._start_s = self._clock.now_s()
        self._sample = 0
        self._offset_s = self._clock.wall_ms() / 1000 + 0.0005 - self._start_s
        self._next_second = math.floor(self._start_s + self._offset_s) + 1
        self._burst_sample = _BURST_SAMPLES

    def read(self) -> Sound:
        end_s = self._start_s + (self._sample + BLOCK_SAMPLES) / SAMPLE_RATE_HZ
        if self._clock.now_s() - end_s > _LATE_S:
            self.catch_up()
            end_s = self._start_s + (self._sample + BLOCK_SAMPLES) / SAMPLE_RATE_HZ
        _sleep_until(end_s, self._clock, self._sleep)
        self._follow_wall_clock()
        captured_s = self._start_s + self._sample / SAMPLE_RATE_HZ
        index = self._sample + np.arange(BLOCK_SAMPLES)
        # 300 Hz repeats every 160 samples: the argument stays small however long this runs.
        wave = _TONE_AMPLITUDE * np.sin(index % 160 * (2 * np.pi * _TONE_HZ / SAMPLE_RATE_HZ))
        self._add_burst(wave, captured_s + self._offset_s)
        self._sample += BLOCK_SAMPLES
        return Sound(samples=np.round(wave * 32767).astype(np.int16), captured_s=captured_s)

    def close(self) -> None:
        """Do nothing: there is nothing to release."""

    def catch_up(self) -> None:
        """Skip to the block that begins now."""
        now = math.ceil((self._clock.now_s() - self._start_s) * SAMPLE_RATE_HZ)
        self._sample = max(self._sample, now)
        self._burst_sample = _BURST_SAMPLES

    def _follow_wall_clock(self) -> None:
        """Refine the estimate of wall minus monotonic time.

        `wall_ms` is in whole milliseconds, so each reading bounds the offset to within 1 ms; the
        estimate moves only when it is outside the bounds.
        """
        low_s = self._clock.wall_ms() / 1000 - self._clock.now_s()
        self._offset_s = min(max(self._offset_s, low_s), low_s + 0.001)

    def _add_burst(self, wave: NDArray[np.float64], wall_s: float) -> None:
        # Sound was dropped, or the wall clock was set: a missed burst is skipped.
        if not -1.5 < wall_s - self._next_second < _BURST_LATE_S:
            self._next_second = math.floor(wall_s) + 1
        begin = 0
        until_burst = round((self._next_second - wall_s) * SAMPLE_RATE_HZ)
        if until_burst < len(wave):
            begin = max(0, until_burst)
            self._next_second += 1
            self._burst_sample = 0
        count = min(len(wave) - begin, _BURST_SAMPLES - self._burst_sample)
        if count > 0:
            phase = (self._burst_sample + np.arange(count)) * (_BURST_HZ / SAMPLE_RATE_HZ)
            wave[begin : begin + count] += _BURST_AMPLITUDE * np.sin(2 * np.pi * phase)
            self._burst_sample += count


def _sleep_until(moment_s: float, clock: Clock, sleep: Callable[[float], None]) -> None:
    remaining_s = moment_s - clock.now_s()
    if remaining_s > 0:
        sleep(remaining_s)


def _cells(wall_ms: int, width: int, height: int) -> NDArray[np.uint8]:
    stamp = (wall_ms % STAMP_MODULUS).to_bytes(5, "big")
    bits = np.unpackbits(np.frombuffer(stamp + bytes([crc8(stamp)]), np.uint8))
    greys = np.where(bits.reshape(ROWS, COLUMNS), _WHITE, _BLACK).astype(np.uint8)
    rows = np.arange(height) * ROWS // height
    columns = np.arange(width) * COLUMNS // width
    return greys[:, columns][rows]


@cache
def _texture(width: int, height: int) -> NDArray[np.uint8]:
    """Return noise of three grain sizes, tiled twice each way so that any window fits.

    It stays near mid-grey, so that it cannot be read as cells.
    """
    noise = np.random.default_rng(2004).standard_normal((height, width)).astype(np.float32)
    total = np.zeros_like(noise)
    for sigma, weight in ((0.7, 0.5), (3.0, 0.7), (12.0, 1.0)):
        margin = math.ceil(3 * sigma)
        blurred = cv2.GaussianBlur(np.pad(noise, margin, mode="wrap"), (0, 0), sigma)
        inner = blurred[margin:-margin, margin:-margin]
        total += inner * (weight / inner.std())
    grey = np.clip(_MIDDLE + 20 * total, _MIDDLE - 32, _MIDDLE + 32)
    return np.tile(grey.astype(np.uint8), (2, 2))


def _window(
    tile: NDArray[np.uint8], left: int, top: int, width: int, height: int
) -> NDArray[np.uint8]:
    top %= tile.shape[0] // 2
    left %= tile.shape[1] // 2
    return tile[top : top + height, left : left + width]
