"""Detects a failed channel of a stereo microphone, so that both ears still hear. Pure."""

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
"""A channel has failed after missing this much sound in total: people pause between words."""
_BACK_S: Final = 1.0
"""A failed channel is good again after this much sound of its own without another fault."""
_ALIKE_S: Final = 10.0
"""Channels that stay identical for this long carry one microphone twice."""

_SOUND_RMS: Final = 30.0
"""Sound is at least this loud (−61 dB of full scale); the noise of a quiet room is softer."""
_FAR_APART: Final = 10.0 ** (40.0 / 20.0)
"""A level difference of 40 dB: more than a head's shadow ever causes between two ears."""
_FULL: Final = 32_000
_FULL_SHARE: Final = 0.8
"""A channel with this share of its samples at full scale is broken; no loud sound stays there."""

_SIDES: Final = ("left", "right")


class ChannelFaults:
    """Passes sound on with only those channels that carry something of their own.

    Mono stays mono. Stereo becomes mono where one channel has failed, that is, where it is silent
    while the other has sound, or stuck at full scale; and where both channels are identical.
    `report` gets a sentence when a channel fails, and None when it works again.
    """

    def __init__(self, report: Callable[[str | None], None], *, most: int = MOST_CHANNELS) -> None:
        self._report = report
        self._most = most
        self._bad_s = [0.0, 0.0]
        self._good_s = [0.0, 0.0]
        self._failed: int | None = None
        self._alike_s = _ALIKE_S
        self.problem: str | None = None
        """A sentence while one of two channels has failed, otherwise None."""

    def push(self, sound: Sound) -> Sound:
        """Return the sound with the channels that are good.

        Raises `SourceError` for samples of a shape or type that no source may deliver.
        """
        _check(sound.samples)
        if channels_of(sound.samples) == 1:
            self._reset()
            return Sound(sound.samples.reshape(-1), sound.captured_s)
        if not len(sound.samples):
            return sound
        length_s = len(sound.samples) / SAMPLE_RATE_HZ
        self._judge(sound.samples, length_s)
        if self._failed is not None:
            return Sound(sound.samples[:, 1 - self._failed], sound.captured_s)
        self._compare(sound.samples, length_s)
        return sound.with_channels(1 if self._alike_s >= _ALIKE_S else self._most)

    def _reset(self) -> None:
        """Start over, because the source has one channel now."""
        self._bad_s, self._good_s = [0.0, 0.0], [0.0, 0.0]
        self._alike_s = _ALIKE_S
        self._set_failed(None, None)

    def _judge(self, samples: NDArray[np.int16], length_s: float) -> None:
        # Deviation from the mean: a constant offset is not sound.
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
            self._set_failed(None, None)
        if self._failed is None:
            for side, fault in enumerate(faults):
                if fault is not None and self._bad_s[side] >= _FAILED_S:
                    self._set_failed(side, fault)
                    return

    def _compare(self, samples: NDArray[np.int16], length_s: float) -> None:
        if np.array_equal(samples[:, 0], samples[:, 1]):
            self._alike_s += length_s
        else:
            self._alike_s = 0.0

    def _set_failed(self, failed: int | None, fault: Failure | None) -> None:
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
            self._report(problem)


def _faults(
    samples: NDArray[np.int16], loudness: NDArray[np.float64]
) -> tuple[Failure | None, Failure | None]:
    """Return what is wrong with each channel, left first; no fault that both channels share."""
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
    """Raise `SourceError` for samples that a driver or a plug-in must not deliver."""
    is_shaped = samples.ndim == 1 or (samples.ndim == 2 and 1 <= channels_of(samples) <= 2)
    if not is_shaped or samples.dtype != np.int16:
        raise SourceError(
            Sentence("microphone.odd", {"type": str(samples.dtype), "shape": str(samples.shape)})
        )
