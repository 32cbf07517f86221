"""What the camera and the microphone deliver while the host wants privacy."""

from __future__ import annotations

from dataclasses import replace

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
    assert picture is not None
    assert picture.i420.shape == PICTURE.i420.shape
    assert np.unique(picture.i420[:4]).tolist() == [16]
    assert np.unique(picture.i420[4:]).tolist() == [128]
    assert sound.samples.tolist() == [0, 0, 0]
    assert (picture.captured_s, sound.captured_s) == (1.5, 2.5)


def test_black_is_encoded_ten_times_a_second_and_the_first_and_last_at_once() -> None:
    """Nothing of the camera's passes meanwhile, and the same black array serves for all."""
    is_on = True
    blanking = Blanking(lambda: is_on)
    film = [replace(PICTURE, captured_s=5.0 + number / 30) for number in range(30)]
    shown = [one for one in map(blanking.picture, film) if one is not None]
    assert [one.captured_s for one in shown] == [one.captured_s for one in film[::3]]
    assert all(one.i420 is shown[0].i420 for one in shown)
    is_on = False
    assert blanking.picture(PICTURE) is PICTURE
    is_on = True
    assert blanking.picture(film[-1]) is not None


@pytest.mark.parametrize("thing", [PICTURE, SOUND])
def test_otherwise_both_pass(thing: Picture | Sound) -> None:
    """Without blanking, picture and sound pass without a copy."""
    blanking = Blanking(lambda: False)
    passed = blanking.picture(thing) if isinstance(thing, Picture) else blanking.sound(thing)
    assert passed is thing
