"""Writes the voice to a WAV file instead of playing it; the file is complete after each write."""

from __future__ import annotations

import struct
from typing import IO, TYPE_CHECKING, Final

from wax.errors import SpeakerError, reason_of
from wax.sentence import Sentence
from wax.voice.packet import RATE_HZ

if TYPE_CHECKING:
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray

_HEADER: Final = struct.Struct("<4sL4s4sLHHLLHH4sL")
_PCM: Final = 1
_MAX_BYTES: Final = 2**31
"""Six hours; a WAV file's length field ends at twice that."""


class FileSpeaker:
    """Appends speech without its pauses to a file of 48 kHz mono, 16 bit.

    The header is correct after each `write`, so that a power cut loses nothing.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._file: IO[bytes] | None = None
        self._bytes = 0

    def open(self) -> None:
        self.close()
        try:
            is_new = not self._path.exists() or self._path.stat().st_size == 0
            self._file = self._path.open("w+b" if is_new else "r+b")
            self._bytes = 0 if is_new else self._existing_bytes(self._file)
            self._write_header(self._file)
        except OSError as error:
            self.close()
            raise SpeakerError(
                Sentence(
                    "speaker.file_not_open",
                    {"file": str(self._path), "why": reason_of(error)},
                )
            ) from error

    def write(self, samples: NDArray[np.int16]) -> None:
        if self._file is None:
            raise SpeakerError(f"{self._path} was written before it was opened.")
        if self._bytes > _MAX_BYTES:
            raise SpeakerError(Sentence("speaker.file_full", {"file": str(self._path)}))
        try:
            self._file.seek(_HEADER.size + self._bytes)
            self._bytes += self._file.write(samples.astype("<i2").tobytes())
            self._write_header(self._file)
        except OSError as error:
            raise SpeakerError(
                Sentence(
                    "speaker.file_failed",
                    {"file": str(self._path), "why": reason_of(error)},
                )
            ) from error

    def close(self) -> None:
        file, self._file = self._file, None
        if file is not None:
            file.close()

    def _existing_bytes(self, file: IO[bytes]) -> int:
        """Return how many bytes of sound the file holds already."""
        head = file.read(_HEADER.size)
        ours = _header(0)
        # Compare all but the two lengths, at bytes 4 and 40.
        if len(head) < _HEADER.size or head[:4] != ours[:4] or head[8:40] != ours[8:40]:
            raise SpeakerError(Sentence("speaker.file_not_ours", {"file": str(self._path)}))
        return (self._path.stat().st_size - _HEADER.size) // 2 * 2

    def _write_header(self, file: IO[bytes]) -> None:
        file.seek(0)
        file.write(_header(self._bytes))
        file.flush()


def _header(size: int) -> bytes:
    return _HEADER.pack(
        *(b"RIFF", _HEADER.size - 8 + size, b"WAVE"),
        *(b"fmt ", 16, _PCM, 1, RATE_HZ, 2 * RATE_HZ, 2, 16),
        *(b"data", size),
    )
