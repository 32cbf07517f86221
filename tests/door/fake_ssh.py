"""A fake ssh whose messages come from a pipe."""

from __future__ import annotations

import os
import threading

WITHIN_S = 10.0


class Ssh:
    """A fake ssh that prints and ends as a test tells it to."""

    def __init__(self) -> None:
        reading, self._said = os.pipe()
        self.stderr = os.fdopen(reading, "rb")
        self._ended = threading.Event()

    def says(self, words: bytes) -> None:
        os.write(self._said, words)

    def ends(self, words: bytes = b"") -> None:
        if not self._ended.is_set():
            self._ended.set()
            self.says(words)
            os.close(self._said)

    terminate = kill = ends

    def wait(self) -> int:
        assert self._ended.wait(WITHIN_S)
        return 255
