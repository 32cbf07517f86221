"""Memory shared by two processes, for one picture at a time.

The media process writes a picture only when asked and then answers; the server copies it before it
asks again. So no picture is ever torn, without a lock that a dying process could hold; and since an
answer lies between writing and reading, the server sees all written bytes.
"""

from __future__ import annotations

import mmap
import os
import sys
import tempfile
from typing import TYPE_CHECKING, Final

import numpy as np

from wax.capture.source import Picture
from wax.robot.media.messages import MAX_HEIGHT, MAX_WIDTH

if TYPE_CHECKING:
    from numpy.typing import NDArray

SIZE_BYTES: Final = MAX_WIDTH * MAX_HEIGHT * 3 // 2


def make_memory() -> int:
    """Return the descriptor of new memory; only written pages use real memory."""
    if sys.platform == "linux":
        descriptor = os.memfd_create("wax-picture")
    else:
        with tempfile.TemporaryFile() as file:
            descriptor = os.dup(file.fileno())
    os.ftruncate(descriptor, SIZE_BYTES)
    return descriptor


class PictureMemory:
    """One end of the memory behind `descriptor`, which may be closed afterwards."""

    def __init__(self, descriptor: int) -> None:
        self._bytes: NDArray[np.uint8] = np.frombuffer(
            mmap.mmap(descriptor, SIZE_BYTES), dtype=np.uint8
        )

    def write(self, i420: NDArray[np.uint8]) -> None:
        """Store a picture of at most `MAX_WIDTH` × `MAX_HEIGHT`."""
        self._bytes[: i420.size].reshape(i420.shape)[:] = i420

    def read(self, width: int, height: int, captured_s: float, within_s: float | None) -> Picture:
        """Return a copy of the stored picture."""
        shape = (height * 3 // 2, width)
        i420 = self._bytes[: shape[0] * width].reshape(shape).copy()
        return Picture(i420, captured_s, within_s)
