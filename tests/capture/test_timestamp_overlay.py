"""The time on the picture: readable on any background, on a copy of the picture."""

from __future__ import annotations

import numpy as np
import pytest

from wax.capture.source import Picture
from wax.capture.timestamp_overlay import TimestampOverlay, overlay_time, wall_text

NOW_MS = 1_795_249_152_112


def plain(width: int, height: int, grey: int) -> Picture:
    i420 = np.full((height * 3 // 2, width), 128, np.uint8)
    i420[:height] = grey
    return Picture(i420, 12.5)


def test_the_text_is_the_moment_in_utc() -> None:
    """The text is date, time and milliseconds in UTC, marked as UTC."""
    assert wall_text(NOW_MS) == "2026-11-21 08:19:12.112Z"
    assert wall_text(1_000) == "1970-01-01 00:00:01.000Z"


SIZES = [(160, 120), (640, 480), (1280, 720), (32, 32), (90, 160), (3840, 64), (32, 2160)]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("grey", [16, 128, 235])
def test_it_can_be_read_on_any_ground(size: tuple[int, int], grey: int) -> None:
    """White digits with a dark outline, in the lower quarter only, as wide as fits."""
    width, height = size
    picture = plain(width, height, grey)
    before = picture.i420.copy()
    printed = overlay_time(picture, NOW_MS)
    assert np.array_equal(picture.i420, before)
    assert printed.captured_s == 12.5
    rows, columns = np.nonzero(printed.i420[:height] != grey)
    assert rows.min() > height * 3 // 4
    assert columns.max() - columns.min() > min(width * 0.8, height * 2)
    assert np.array_equal(printed.i420[height:], before[height:])
    if width >= 160:
        strip = printed.i420[rows.min() : rows.max() + 1]
        assert strip.max() > 200
        assert strip.min() < 60


def test_a_millisecond_can_be_seen() -> None:
    """Two times 1 ms apart look different, the same time looks the same."""
    picture = plain(640, 480, 90)
    first, again = overlay_time(picture, NOW_MS), overlay_time(picture, NOW_MS)
    assert np.array_equal(first.i420, again.i420)
    assert (first.i420 != overlay_time(picture, NOW_MS + 1).i420).sum() > 20


def test_it_is_the_time_of_the_capture() -> None:
    """A picture that was captured 0.25 s ago carries the wall clock's time of that moment."""

    class Clock:
        def now_s(self) -> float:
            return 12.75

        def wall_ms(self) -> int:
            return NOW_MS

    got: list[Picture] = []
    TimestampOverlay(Clock(), got.append)(plain(640, 480, 90))
    assert np.array_equal(got[0].i420, overlay_time(plain(640, 480, 90), NOW_MS - 250).i420)
