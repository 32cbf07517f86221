"""Judges the two channels of a microphone: one that fails must not cost an ear. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from wax.capture.channels import MOST_CHANNELS, channels_of
from wax.capture.source import SAMPLE_RATE_HZ, Sound
from wax.errors import SourceError
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

Failure = Literal["silent", "overdriven"]

_FAILED_S: Final = 2.0
"""A channel fails after so much sound of which it has nothing: the sum, since people pause."""
_BACK_S: Final = 1.0
"""And it is good again after so much sound of its own, without a fault between."""
_ALIKE_S: Final = 10.0
"""Channels without any difference for so long are one microphone twice."""

_SOUND_RMS: Final = 30.0
"""From this on there is sound (−61 dB of full scale): the noise of a quiet room is less."""
_FAR_APART: Final = 10.0 ** (40.0 / 20.0)
"""No head's shadow is as deep as these 40 dB between one channel and the other."""
_FULL: Final = 32_000
_FULL_SHARE: Final = 0.8
"""A channel with so much of its sound at full scale is broken; no loud sound stays there."""

_SIDES: Final = ("left", "right")


class ChannelFaults:
    """Passes sound on with as many channels as carry something of their own.

    One channel stays one. Two become one where the other has failed: it is silent while there is
    sound, or stands at full scale. They become one, too, where both are the same. `tell` gets a
    sentence when a channel fails, and None when it is back.
    """

    def __init__(self, tell: Callable[[str | None], None], *, most: int = MOST_CHANNELS) -> None:
        self._tell = tell
        self._most = most
        self._bad_s = [0.0, 0.0]
        self._good_s = [0.0, 0.0]
        self._failed: int | None = None
        self._alike_s = _ALIKE_S
        self.problem: str | None = None
        """A sentence while one of two channels has failed, else None."""

    def push(self, sound: Sound) -> Sound:
        """Return the sound with the channels that are good.

        Raises `SourceError` for samples of another shape or type than a source's.
        """
        _check(sound.samples)
        if channels_of(sound.samples) == 1:
            self._forget()
            return Sound(sound.samples.reshape(-1), sound.captured_s)
        if not len(sound.samples):
            return sound
        length_s = len(sound.samples) / SAMPLE_RATE_HZ
        self._judge(sound.samples, length_s)
        if self._failed is not None:
            return Sound(sound.samples[:, 1 - self._failed], sound.captured_s)
        self._compare(sound.samples, length_s)
        return sound.with_channels(1 if self._alike_s >= _ALIKE_S else self._most)

    def _forget(self) -> None:
        """Begin anew: the source has one channel now."""
        self._bad_s, self._good_s = [0.0, 0.0], [0.0, 0.0]
        self._alike_s = _ALIKE_S
        self._say(None, None)

    def _judge(self, samples: NDArray[np.int16], length_s: float) -> None:
        # Around the mean: a constant is no sound.
        loudness = samples.std(axis=0)
        faults = _faults(samples, loudness)
        for side, fault in enumerate(faults):
            if fault is not None:
                self._bad_s[side] += length_s
                self._good_s[side] = 0.0
            elif loudness[side] >= _SOUND_RMS:
                self._bad_s[side] = 0.0
                self._good_s[side] += length_s
        if self._failed is not None and self._good_s[self._failed] >= _BACK_S:
            self._say(None, None)
        if self._failed is None:
            for side, fault in enumerate(faults):
                if fault is not None and self._bad_s[side] >= _FAILED_S:
                    self._say(side, fault)
                    return

    def _compare(self, samples: NDArray[np.int16], length_s: float) -> None:
        if np.array_equal(samples[:, 0], samples[:, 1]):
            self._alike_s += length_s
        else:
            self._alike_s = 0.0

    def _say(self, failed: int | None, fault: Failure | None) -> None:
        self._failed = failed
        problem = None
        if failed is not None and fault is not None:
            how = "is silent" if fault == "silent" else "stands at full scale"
            problem = (
                f"The microphone's {_SIDES[failed]} channel {how}; both ears get the"
                f" {_SIDES[1 - failed]} one. Check the cable and the capsule."
            )
        if problem != self.problem:
            self.problem = problem
            self._tell(problem)


def _faults(
    samples: NDArray[np.int16], loudness: NDArray[np.float64]
) -> tuple[Failure | None, Failure | None]:
    """Return what is wrong with each channel, left first; nothing where both are alike in it."""
    full = (np.abs(samples.astype(np.int32)) >= _FULL).mean(axis=0) >= _FULL_SHARE
    if full.any():
        return (
            ("overdriven", None) if not full[1] else (None, "overdriven" if not full[0] else None)
        )
    left, right = (float(one) for one in loudness)
    if right >= _SOUND_RMS and left * _FAR_APART < right:
        return "silent", None
    if left >= _SOUND_RMS and right * _FAR_APART < left:
        return None, "silent"
    return None, None


def _check(samples: NDArray[np.int16]) -> None:
    """Raise `SourceError` for what a driver or a class of the host's should not deliver."""
    is_shaped = samples.ndim == 1 or (samples.ndim == 2 and 1 <= channels_of(samples) <= 2)
    if not is_shaped or samples.dtype != np.int16:
        raise SourceError(
            Sentence("microphone.odd", {"type": str(samples.dtype), "shape": str(samples.shape)})
        )
