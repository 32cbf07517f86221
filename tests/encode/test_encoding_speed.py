"""The trial of the processor."""

from __future__ import annotations

import itertools

import pytest

from wax.config.video import RenditionSettings
from wax.encode.speed import encode_ms, most_ms

SMALL = RenditionSettings(width=160, height=90, fps=30, bitrate_bps=200_000)


@pytest.mark.parametrize("codec", ["vp8", "h264"])
def test_a_picture_is_really_encoded(codec: str) -> None:
    """A small picture takes some of the processor's time, and less than a second of it."""
    assert 0 < encode_ms(SMALL, codec) < 1000  # type: ignore[arg-type]


def test_the_median_picture_counts() -> None:
    """One slow picture among the eight decides nothing, and the first, a keyframe, is left out."""
    times = iter([0.0, *itertools.chain(*([n, n + 0.01] for n in range(1, 8))), 20.0, 21.0])
    assert encode_ms(SMALL, "vp8", cpu_s=lambda: next(times)) == pytest.approx(10)


def test_a_very_slow_machine_is_not_kept_waiting() -> None:
    """After a third of a second the pictures so far are enough."""
    clock, cpu = itertools.count(0.0, 0.3), itertools.count(0.0, 0.3)
    told = encode_ms(SMALL, "vp8", cpu_s=lambda: next(cpu), now_s=lambda: next(clock))
    assert told == pytest.approx(300)
    assert next(cpu) < 2.5


def test_a_single_core_does_more_than_encode() -> None:
    """At 30 fps a picture may take 20 ms, with one core 12 ms, and half a core less."""
    assert [round(most_ms(30, usable), 1) for usable in (4, 2, 1, 0.5)] == [20.0, 20.0, 11.7, 5.8]
