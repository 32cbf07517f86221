"""The array shapes of mono and stereo sound, and conversion between them. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

MOST_CHANNELS: Final = 2


def channels_of(samples: NDArray[np.int16]) -> int:
    """Return how many channels samples of the shape ``(n,)`` or ``(n, channels)`` have."""
    return 1 if samples.ndim == 1 else int(samples.shape[1])


def with_channels(samples: NDArray[np.int16], channels: int) -> NDArray[np.int16]:
    """Return the samples as ``(n,)`` for one channel, ``(n, 2)`` for two.

    Stereo is downmixed to its mean, which cannot overflow; mono is copied to both channels.
    """
    if channels == channels_of(samples):
        return samples
    if channels == MOST_CHANNELS:
        return np.column_stack((samples, samples))
    return np.asarray(samples.astype(np.int32).sum(axis=1) // MOST_CHANNELS, np.int16)
