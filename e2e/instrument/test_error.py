"""The instrument's own error is demonstrated, not assumed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from e2e.delay.browser import open_browser
from e2e.instrument.cards import LIE_MS, lies
from e2e.instrument.error import judged, own_error, shift
from e2e.instrument.synthetic import readings
from e2e.link import Link

if TYPE_CHECKING:
    from pathlib import Path

    from e2e.delay.readings import Readings


@pytest.mark.parametrize("wrong_ms", [0.0, -8.0, 30.0])
def test_a_shift_that_is_read_wrong_is_told(wrong_ms: float) -> None:
    """The shift that an instrument reads is reported as it is, even while all ages drift."""
    stamps = [10_000_000.0 + 33 * n for n in range(600)]
    read = [
        (stamp, 80 + n / 20 + ((LIE_MS + wrong_ms) if lies(stamp) else 0))
        for n, stamp in enumerate(stamps)
    ]
    found = shift(read)
    assert found is not None
    assert found.ms == pytest.approx(LIE_MS + wrong_ms, abs=0.5)
    assert found.uncertain_ms < 0.5


def test_an_instrument_that_reads_wrong_is_not_ok() -> None:
    """A lie read as 90 instead of 100, two readings 6 ms apart, or no sound at all: not ok."""
    right = readings(20, lie_ms=100)
    assert verdict(right, right) == (True, True)
    assert not verdict(readings(20, lie_ms=90), readings(20, lie_ms=90))[0]
    assert not verdict(right, readings(20, lie_ms=100, picture_age_ms=86))[0]
    assert not verdict(right, readings(20, lie_ms=100, sound_age_ms=126))[0]
    assert verdict(readings(20, lie_ms=100, sound=False), right) == (False, False)


def verdict(first: Readings, second: Readings) -> tuple[bool, bool]:
    rows, is_certain = judged(first, second)
    assert len(rows) == 2
    return all(row.met for row in rows), is_certain


@pytest.mark.timeout(150)
async def test_two_agree_and_a_lie_is_read(tmp_path: Path) -> None:
    """In Chromium two on one page agree within 5 ms, and the source's +100 ms is read as such."""
    async with Link("same-machine") as link, open_browser(link) as browser:
        rows = await own_error(link, browser, tmp_path)
    assert [row.what for row in rows if not row.met] == []
