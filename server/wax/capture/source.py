"""The interface of a camera or microphone: three methods, called from one thread.

For a device of your own, write a class with these methods and name it in the configuration as
``package.module:Class``, or by your package's entry point in the group ``wax.cameras`` or
``wax.microphones``. It is built as ``Class(settings, clock)`` with the configuration's
`VideoSettings` or `AudioSettings`. A dedicated thread then calls `open`, `read` repeatedly, and
`close`, so `read` may block. A `SourceError` from `open` or `read` is shown on the page, and the
source is closed and opened again after a pause.

After `read`, pictures are turned as ``rotate`` and ``mirror`` of the settings say; a class that
turns them itself declares ``is_upright = True``.

While nobody needs what it delivers, a class that declares ``rest_s`` is read only once in so many
seconds. It promises that, however long it was left unread, the next `read` returns no older a
picture or sound than if it had been read all along; ``catch_up``, if it has that method, is called
after each rest and drops what was captured meanwhile.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Protocol

import cv2

from wax.capture.channels import channels_of, with_channels

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

SAMPLE_RATE_HZ = 48_000
"""All sound inside WAX is 48 kHz signed 16 bit, mono or stereo: the native form of Opus."""

BLOCK_MS = 10
BLOCK_SAMPLES = SAMPLE_RATE_HZ * BLOCK_MS // 1000
"""All sound is cut into blocks of this length, the shortest media unit."""

REST_S: Final = 0.9
"""A source's ``rest_s``: below 1 s, so that the rates of a second in status and metrics show it."""


@dataclass(frozen=True, slots=True)
class Picture:
    """One picture, planar YUV 4:2:0 (I420), BT.601 in limited range: black is 16, white 235.

    `i420` has shape ``(height * 3 // 2, width)``, dtype uint8: the luma plane on top, below it
    the two chroma planes. Width and height are even. The array is never changed afterwards.
    `captured_s` is the moment of capture on the server's monotonic clock. `within_s` is its error
    bound, which the gate adds to the picture's age; None means that the age is unknown, and the
    picture can be watched but not driven by.
    """

    i420: NDArray[np.uint8]
    captured_s: float
    within_s: float | None = None

    @property
    def width(self) -> int:
        return int(self.i420.shape[1])

    @property
    def height(self) -> int:
        return int(self.i420.shape[0]) * 2 // 3

    @classmethod
    def from_bgr(
        cls, bgr: NDArray[np.uint8], captured_s: float, within_s: float | None = None
    ) -> Picture:
        """Convert an OpenCV image ``(height, width, 3)``; an odd edge is cut off."""
        height, width = bgr.shape[0] & ~1, bgr.shape[1] & ~1
        i420 = cv2.cvtColor(bgr[:height, :width], cv2.COLOR_BGR2YUV_I420)
        return cls(i420, captured_s, within_s)  # type: ignore[arg-type]  # cv2 forgets the dtype


@dataclass(frozen=True, slots=True)
class Sound:
    """A piece of sound: `samples` int16 at 48 kHz, n ≥ 1 of them.

    The shape is ``(n,)`` for one channel and ``(n, 2)`` for two, the left one first. `captured_s`
    is when the first sample was captured, on the server's monotonic clock.
    """

    samples: NDArray[np.int16]
    captured_s: float

    @property
    def channels(self) -> int:
        return channels_of(self.samples)

    def with_channels(self, channels: int) -> Sound:
        """Return the same sound as mono (1) or stereo (2)."""
        if channels == self.channels:
            return self
        return Sound(with_channels(self.samples, channels), self.captured_s)


class VideoSource(Protocol):
    """Delivers pictures at its own speed."""

    def open(self) -> None:
        """Get ready; raises `SourceError` with a sentence for a person."""
        ...

    def read(self) -> Picture:
        """Block until the next picture (at most 2 s); raises `SourceError`."""
        ...

    def close(self) -> None:
        """Release the device. Safe to call twice and without `open`."""
        ...


class AudioSource(Protocol):
    """Delivers sound at its own speed, in pieces of any length; 10 ms keeps the delay short."""

    def open(self) -> None:
        """Get ready; raises `SourceError` with a sentence for a person."""
        ...

    def read(self) -> Sound:
        """Block until the next piece (at most 2 s); raises `SourceError`."""
        ...

    def close(self) -> None:
        """Release the device. Safe to call twice and without `open`."""
        ...
