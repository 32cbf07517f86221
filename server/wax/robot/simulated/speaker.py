"""The simulated robot's speaker, which its own microphone hears."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Final

import numpy as np

from wax.capture.source import SAMPLE_RATE_HZ

if TYPE_CHECKING:
    from numpy.typing import NDArray

_MOST: Final = SAMPLE_RATE_HZ // 5
"""The longest queue; more would only add delay."""


class SimulatedSpeaker:
    """A queue of samples: each written sample is returned once, by `heard`."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._waiting = np.zeros(0, np.int16)

    def open(self) -> None:
        self.close()

    def write(self, samples: NDArray[np.int16]) -> None:
        with self._lock:
            room = max(0, _MOST - len(self._waiting))
            self._waiting = np.concatenate((self._waiting, samples[:room]))

    def close(self) -> None:
        with self._lock:
            self._waiting = np.zeros(0, np.int16)

    def heard(self, count: int) -> NDArray[np.float64]:
        """Return the next `count` samples, silence if the queue is empty; 1 is full scale."""
        with self._lock:
            now, self._waiting = self._waiting[:count], self._waiting[count:]
        return np.pad(now / 32_768.0, (0, count - len(now)))
