"""The simulated head and its two ears."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.capture.source import BLOCK_SAMPLES, SAMPLE_RATE_HZ
from wax.robot.simulated.ears import Ears, brightness, delay_samples

bearings = st.floats(-4.0, 4.0)


@given(bearing_rad=bearings)
def test_left_and_right_are_mirrored(bearing_rad: float) -> None:
    """Mirrored directions swap the ears; front and back are alike."""
    left, right = delay_samples(bearing_rad)
    assert delay_samples(-bearing_rad) == pytest.approx((right, left), abs=1e-6)
    assert delay_samples(math.pi - bearing_rad) == pytest.approx((left, right), abs=1e-6)
    assert brightness(-bearing_rad) == pytest.approx(brightness(bearing_rad)[::-1], abs=1e-6)


@given(bearing_rad=st.floats(0.1, math.pi - 0.1))
def test_the_nearer_ear_is_sooner_and_brighter(bearing_rad: float) -> None:
    """From the left, the right ear hears later, by at most 0.66 ms, and duller."""
    left, right = delay_samples(bearing_rad)
    assert 0 < right - left <= 0.66e-3 * SAMPLE_RATE_HZ
    assert brightness(bearing_rad)[0] > brightness(bearing_rad)[1]


def tone(hertz: float, seconds: float = 1.0) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    count = round(seconds * 100) * BLOCK_SAMPLES
    return np.asarray(np.sin(np.arange(count) * (2 * np.pi * hertz / SAMPLE_RATE_HZ)))


@pytest.mark.parametrize(("hertz", "least_db", "most_db"), [(150, 0, 1.5), (6000, 15, 30)])
def test_the_head_shades_high_tones(hertz: float, least_db: float, most_db: float) -> None:
    """From the side, a low tone goes around the head, a high one is at least 15 dB down."""
    ears = Ears()
    heard = np.concatenate(
        [ears.hear(part, math.radians(60)) for part in tone(hertz).reshape(-1, BLOCK_SAMPLES)]
    )[SAMPLE_RATE_HZ // 10 :]
    left, right = np.sqrt(np.mean(heard**2, axis=0))
    assert least_db <= 20 * math.log10(left / right) <= most_db


def test_turning_makes_no_click() -> None:
    """While the head turns through all directions, a tone stays smooth across blocks."""
    ears = Ears()
    parts = tone(440.0, 4.0).reshape(-1, BLOCK_SAMPLES)
    heard = np.concatenate([ears.hear(part, 0.03 * n) for n, part in enumerate(parts)])
    bend = np.abs(np.diff(heard, 2, axis=0)).max(axis=1)[BLOCK_SAMPLES:]
    places = np.arange(len(bend)) % BLOCK_SAMPLES
    border = (places == BLOCK_SAMPLES - 1) | (places == BLOCK_SAMPLES - 2)
    assert bend[border].max() <= 1.05 * bend[~border].max()
