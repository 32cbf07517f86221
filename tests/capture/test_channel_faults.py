"""A stereo microphone's failed channel is left out."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wax.capture.channel_faults import ChannelFaults
from wax.capture.source import Sound
from wax.errors import SourceError

Samples = np.ndarray[tuple[int, ...], np.dtype[np.int16]]
RANDOM = np.random.default_rng(4)


def noise(rms: float, count: int = 480) -> Samples:
    return np.clip(RANDOM.normal(0.0, rms, count), -32768, 32767).astype(np.int16)


def both(left: Samples, right: Samples) -> Sound:
    return Sound(np.column_stack((left, right)), 1.0)


def constant(value: int) -> Samples:
    return np.full(480, value, np.int16)


def railed() -> Samples:
    return np.where(RANDOM.random(480) < 0.5, 32767, -32768).astype(np.int16)


class Listening:
    """Pushes blocks and records the results."""

    def __init__(self, most: int = 2) -> None:
        self.told: list[str | None] = []
        self.faults = ChannelFaults(self.told.append, most=most)

    def hears(self, seconds: float, left: object, right: object) -> Sound:
        """Push this much sound, in blocks made by `left` and `right`."""
        assert callable(left)
        assert callable(right)
        for _ in range(round(seconds * 100)):
            sound = self.faults.push(both(left(), right()))
        return sound


def good() -> Samples:
    return noise(1000.0)


def quiet() -> Samples:
    return noise(5.0)


BROKEN = {
    "zeros": lambda: constant(0),
    "a constant": lambda: constant(-7000),
    "nothing but its own noise": lambda: noise(2.0),
    "full scale": lambda: constant(32767),
    "both ends of the scale": railed,
}


@pytest.mark.parametrize("how", BROKEN)
@pytest.mark.parametrize("side", [0, 1])
def test_one_that_fails_is_left_out(how: str, side: int) -> None:
    """Within 2 s both ears get the good channel, one sentence says so, and recovery is noticed."""
    listening, bad = Listening(), BROKEN[how]
    parts = (bad, good) if side == 0 else (good, bad)
    assert listening.hears(1.0, good, good).channels == 2
    assert listening.hears(1.9, *parts).channels == 2
    faults = listening.faults
    listening.hears(0.2, *parts)
    block = both(parts[0](), parts[1]())
    assert np.array_equal(faults.push(block).samples, block.samples[:, 1 - side])
    assert len(listening.told) == 1
    assert ("left", "right")[side] in str(listening.told[0])
    assert faults.problem == listening.told[0]
    listening.hears(0.9, good, good)
    assert faults.problem is not None
    assert listening.hears(0.2, good, good).channels == 2
    assert faults.problem is None
    assert listening.told[1:] == [None]


def test_a_quiet_room_says_nothing_about_a_capsule() -> None:
    """While there is no sound, no channel fails, whatever it delivers, and none recovers."""
    listening = Listening()
    listening.hears(1.0, good, good)
    listening.hears(4.0, quiet, lambda: constant(0))
    assert listening.told == []
    listening.hears(3.0, good, lambda: constant(0))
    assert len(listening.told) == 1
    listening.hears(4.0, quiet, quiet)
    assert len(listening.told) == 1


def test_words_with_pauses_are_added_up() -> None:
    """A channel fails by the sum of the words that it misses, however short they are."""
    listening = Listening()
    for _ in range(11):
        listening.hears(0.2, good, lambda: constant(0))
        listening.hears(0.3, quiet, lambda: constant(0))
    assert listening.faults.problem is not None


@given(share=st.floats(0.02, 1.0), first=st.booleans())
def test_a_sound_on_one_side_is_no_fault(share: float, first: bool) -> None:
    """Sound up to 34 dB softer in one ear than in the other only has a direction."""
    listening = Listening()
    soft = [lambda: noise(3000.0), lambda: noise(3000.0 * share)]
    left, right = soft if first else reversed(soft)
    assert listening.hears(2.5, left, right).channels == 2
    assert listening.told == []


def test_one_microphone_twice_is_one() -> None:
    """Identical channels are mono until they differ, and again after 10 s."""
    listening = Listening()
    same = good()
    assert listening.hears(0.5, lambda: same, lambda: same).channels == 1
    assert listening.hears(0.1, good, good).channels == 2
    assert listening.hears(9.8, lambda: same, lambda: same).channels == 2
    assert listening.hears(0.3, lambda: same, lambda: same).channels == 1
    assert listening.told == []


def test_an_empty_piece_says_nothing() -> None:
    """An empty piece, with which some devices begin, leaves stereo unchanged."""
    listening = Listening()
    listening.hears(0.5, good, good)
    listening.faults.push(Sound(np.zeros((0, 2), np.int16), 1.0))
    assert listening.hears(0.02, good, good).channels == 2
    same = good()
    assert listening.faults.push(both(same, same)).channels == 2


@pytest.mark.parametrize("shape", [(480,), (480, 1)])
def test_one_channel_passes(shape: tuple[int, ...]) -> None:
    """A driver's mono microphone passes unchanged."""
    samples = good()
    sound = Listening().faults.push(Sound(samples.reshape(shape), 3.0))
    assert np.array_equal(sound.samples, samples)
    assert sound.captured_s == 3.0


def test_mono_is_the_mean_of_two() -> None:
    """With `channels = 1` stereo is averaged without overflow, and a failed channel left out."""
    listening = Listening(most=1)
    loud, soft = constant(32000), constant(31000)
    loud[0], soft[0] = 0, 10
    assert listening.faults.push(both(loud, soft)).samples.tolist() == [5, *[31500] * 479]
    assert listening.hears(2.1, good, lambda: constant(0)).channels == 1
    block = both(good(), constant(0))
    assert np.array_equal(listening.faults.push(block).samples, block.samples[:, 0])


@pytest.mark.parametrize(
    "samples",
    [np.zeros((480, 3), np.int16), np.zeros((480, 2), np.float32), np.zeros((2, 4, 2), np.int16)],
)
def test_another_shape_is_a_sentence(
    samples: np.ndarray[tuple[int, ...], np.dtype[np.int16]],
) -> None:
    """A plug-in that delivers another shape is told which one is expected."""
    with pytest.raises(SourceError, match=r"must be int16 of the shape \(n,\) for one channel"):
        Listening().faults.push(Sound(samples, 1.0))
