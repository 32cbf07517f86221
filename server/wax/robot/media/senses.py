"""A robot's senses in the server: sources and a speaker that ask the media process."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING, Final

import numpy as np

from wax.capture.source import REST_S, Picture, Sound
from wax.errors import SourceError, SpeakerError
from wax.robot.media.link import MediaProcessLink, SenseError
from wax.robot.media.messages import CLOSE, NEWEST, NEXT, OPEN, WRITE
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

READ_S: Final = 2.0
"""The longest that a source may block (`wax.capture.source`)."""
_OPEN_S: Final = 5.0
_CLOSE_S: Final = 0.2


class _RemoteSense:
    """`start` starts the process if it is not running yet, and `end` ends it.

    Without `end` the process keeps a source open, and reopens it if it fails.
    """

    def __init__(
        self,
        link: MediaProcessLink,
        start: Callable[[], None],
        end: Callable[[], None] = lambda: None,
    ) -> None:
        self._link = link
        self._start = start
        self._end = end

    def open(self) -> None:
        self._start()

    def close(self) -> None:
        self._end()


class RemoteCamera(_RemoteSense):
    """A `VideoSource`."""

    rest_s: Final = REST_S

    def read(self) -> Picture:
        try:
            answer, _ = self._link.ask(NEXT, READ_S)
            memory = self._link.memory
            if memory is None or not answer.width or not answer.height:
                raise SenseError(Sentence("camera.silent"))
        except SenseError as error:
            raise SourceError(error.sentence) from error
        return memory.read(answer.width, answer.height, answer.captured_s, answer.within_s)


class RemoteMicrophone(_RemoteSense):
    """An `AudioSource`."""

    rest_s: Final = REST_S
    _question = NEXT

    def catch_up(self) -> None:
        self._question = NEWEST

    def read(self) -> Sound:
        question, self._question = self._question, NEXT
        try:
            answer, payload = self._link.ask(question, READ_S)
        except SenseError as error:
            raise SourceError(error.sentence) from error
        samples = np.frombuffer(payload[: len(payload) & ~3], np.int16)
        if not samples.size:
            raise SourceError(Sentence("microphone.silent"))
        shaped = samples if answer.channels == 1 else samples.reshape(-1, answer.channels)
        return Sound(shaped, answer.captured_s)


class RemoteSpeaker(_RemoteSense):
    """A `Speaker`."""

    def open(self) -> None:
        self._start()
        self._ask(OPEN, _OPEN_S)

    def write(self, samples: NDArray[np.int16]) -> None:
        self._ask(WRITE + np.ascontiguousarray(samples, np.int16).tobytes(), READ_S)

    def close(self) -> None:
        with contextlib.suppress(SenseError):  # it has gone, or is closed when it goes on
            self._link.ask(CLOSE, _CLOSE_S)

    def _ask(self, question: bytes, within_s: float) -> None:
        try:
            self._link.ask(question, within_s)
        except SenseError as error:
            raise SpeakerError(error.sentence) from error
