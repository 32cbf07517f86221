"""The interface of a speaker: three methods, called from one thread.

For an output of your own, write a class with these methods and name it in the configuration as
``package.module:Class``. It is built as ``Class(settings, clock)`` with the configuration's
`VoiceSettings`. A dedicated thread then calls `open`, `write` as sound is due, and `close`. A
`SpeakerError` from `open` or `write` is shown on the page, and the speaker is closed and opened
again after a pause.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class Speaker(Protocol):
    """Plays sound at its own speed."""

    def open(self) -> None:
        """Get ready; raises `SpeakerError` with a sentence for a person."""
        ...

    def write(self, samples: NDArray[np.int16]) -> None:
        """Play these samples after those of earlier calls; raises `SpeakerError`.

        `samples` is mono at 48 kHz, shape ``(n,)``, 1 ≤ n ≤ 5760. While somebody speaks, each piece
        is written up to 20 ms before it is due; in pauses nothing is written. Blocking for longer
        than a piece lasts delays the voice; blocking for a second counts as a failure.
        """
        ...

    def close(self) -> None:
        """Release the device. Safe to call twice and without `open`."""
        ...
