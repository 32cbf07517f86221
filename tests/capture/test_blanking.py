"""What the camera and the microphone deliver while the host wants privacy."""

from __future__ import annotations

import numpy as np
import pytest

from wax.capture.blanking import Blanking
from wax.capture.source import Picture, Sound

PICTURE = Picture(np.arange(6 * 4, dtype=np.uint8).reshape(6, 4), 1.5)
SOUND = Sound(np.array([1, -2, 3], np.int16), 2.5)


def test_nothing_is_left_of_either() -> None:
    """A blanked picture is black and blanked sound silent, of the same size and time."""
    blanking = Blanking(lambda: True)
    picture, sound = blanking.picture(PICTURE), blanking.sound(SOUND)
    assert picture.i420.shape == PICTURE.i420.shape
    assert np.unique(picture.i420[:4]).tolist() == [16]
    assert np.unique(picture.i420[4:]).tolist() == [128]
    assert sound.samples.tolist() == [0, 0, 0]
    assert (picture.captured_s, sound.captured_s) == (1.5, 2.5)


@pytest.mark.parametrize("thing", [PICTURE, SOUND])
def test_otherwise_both_pass(thing: Picture | Sound) -> None:
    """Without blanking, picture and sound pass without a copy."""
    blanking = Blanking(lambda: False)
    passed = blanking.picture(thing) if isinstance(thing, Picture) else blanking.sound(thing)
    assert passed is thing
