"""The media process's end of each sense: it answers the server, whatever the plug-in does.

A source runs in a thread of its own and is reopened after each failure (`SourceThread`); another
thread answers each request with the newest data, or with the current problem.
"""

from __future__ import annotations

import math
import threading
from collections import deque
from typing import TYPE_CHECKING, Any, Final, Protocol

import numpy as np
import structlog

from wax.capture.newest_slot import NewestSlot
from wax.capture.source import Picture, Sound
from wax.capture.source_thread import SourceThread
from wax.errors import SourceError, WaxError, reason_of
from wax.robot.media.messages import (
    CLOSE,
    MAX_HEIGHT,
    MAX_SAMPLES,
    MAX_WIDTH,
    NEWEST,
    OPEN,
    WRITE,
    Answer,
    encode,
)
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Callable
    from multiprocessing.connection import Connection

    from wax.clock import Clock
    from wax.robot.media.picture_memory import PictureMemory

_LOG = structlog.get_logger(__name__)

_LOOK_S: Final = 0.1
_KEPT_SOUNDS: Final = 20
"""Blocks of 10 ms queued for a slow server, 200 ms in all; older ones are dropped."""
_MAX_QUESTION_BYTES: Final = 65_536


class SenseOutlet(Protocol):
    """Answers one sense's questions in threads of its own, until the connection ends."""

    def start(self) -> None: ...

    def request_stop(self) -> None: ...

    def stop(self) -> None: ...


class _Made:
    """A source made only when opened, so that a plug-in's `make` may fail as `open` does."""

    def __init__(self, make: Callable[[], Any], check: Callable[[Any], Any]) -> None:
        self._make = make
        self._check = check
        self._source: Any = None

    def open(self) -> None:
        if self._source is None:
            self._source = self._make()
        self._source.open()

    @property
    def rest_s(self) -> float | None:
        """As long as the server does not ask, if the source may rest at all."""
        may_rest = getattr(self._source, "rest_s", None) is not None
        return threading.TIMEOUT_MAX if may_rest else None

    def read(self) -> Any:
        return self._check(self._source.read())

    def catch_up(self) -> None:
        if hasattr(self._source, "catch_up"):
            self._source.catch_up()

    def close(self) -> None:
        if self._source is not None:
            self._source.close()


class _SourceOutlet:
    """An outlet with one thread for its source and one for its answers."""

    _source: SourceThread[Any]
    _answers: _Answers

    def start(self) -> None:
        self._source.start()
        self._answers.start()

    def request_stop(self) -> None:
        self._source.request_stop()

    def stop(self) -> None:
        self._source.stop()


class CameraOutlet(_SourceOutlet):
    """Writes the newest picture into memory when the server asks for one.

    A camera that may rest does so once the server has left two pictures, which then are too old.
    """

    def __init__(
        self,
        make: Callable[[], Any],
        connection: Connection,
        memory: PictureMemory,
        *,
        name: str,
        clock: Clock,
    ) -> None:
        self._slot = NewestSlot[Picture]()
        self._memory = memory
        self._slot.needed.set()
        self._seen = 0
        self._made = _Made(make, checked_picture)
        self._source = SourceThread(
            self._made, self._put, name=name, clock=clock, needed=self._slot.needed
        )
        self._answers = _Answers(connection, self._next, name)

    def _put(self, picture: Picture) -> None:
        if self._made.rest_s is not None and self._slot.count > self._seen:
            self._slot.needed.clear()  # first: the next request may come before `put` returns
        self._slot.put(picture)

    def _next(self, _question: bytes) -> bytes:
        if not self._slot.needed.is_set():
            self._seen = self._slot.count
            self._slot.needed.set()
        while (found := self._slot.newer_than(self._seen, _LOOK_S)) is None:
            if (problem := self._source.problem) is not None:
                return encode(Answer(problem=problem))
        self._seen, picture = found
        self._memory.write(picture.i420)
        return encode(
            Answer(
                captured_s=picture.captured_s,
                within_s=picture.within_s,
                width=picture.width,
                height=picture.height,
            )
        )


class MicrophoneOutlet(_SourceOutlet):
    """Sends the sound, block by block, as the server asks for it.

    A microphone that may rest does so once the server has left a whole queue.
    """

    def __init__(
        self,
        make: Callable[[], Any],
        connection: Connection,
        *,
        clock: Clock,
    ) -> None:
        self._news = threading.Condition()
        self._sounds = deque[Sound](maxlen=_KEPT_SOUNDS)
        self._needed = threading.Event()
        self._needed.set()
        self._source = SourceThread(
            _Made(make, checked_sound),
            self._put,
            name="microphone",
            clock=clock,
            needed=self._needed,
        )
        self._answers = _Answers(connection, self._next, "microphone")

    def _put(self, sound: Sound) -> None:
        with self._news:
            self._sounds.append(sound)
            if len(self._sounds) == _KEPT_SOUNDS:
                self._needed.clear()
            self._news.notify_all()

    def _next(self, question: bytes) -> bytes:
        with self._news:
            if question == NEWEST:
                self._sounds.clear()
            self._needed.set()
        while True:
            with self._news:
                if not self._sounds:
                    self._news.wait(_LOOK_S)
                if self._sounds:
                    sound = self._sounds.popleft()
                    break
            if (problem := self._source.problem) is not None:
                return encode(Answer(problem=problem))
        head = Answer(captured_s=sound.captured_s, channels=sound.channels)
        return encode(head, np.ascontiguousarray(sound.samples).tobytes())


class SpeakerOutlet:
    """Plays what the server sends; each answer confirms that the speaker has accepted it."""

    def __init__(self, make: Callable[[], Any], connection: Connection) -> None:
        self._make = make
        self._speaker: Any = None
        self._answers = _Answers(connection, self._do, "speaker")

    def start(self) -> None:
        self._answers.start()

    def request_stop(self) -> None:
        """Do nothing: the server closes the speaker before it ends."""

    def stop(self) -> None:
        """Do nothing."""

    def _do(self, question: bytes) -> bytes:
        try:
            if question == OPEN:
                self._speaker = self._speaker or self._make()
                self._speaker.open()
            elif self._speaker is not None and question == CLOSE:
                self._speaker.close()
            elif self._speaker is not None and question.startswith(WRITE):
                self._speaker.write(np.frombuffer(question[len(WRITE) :], np.int16))
        except WaxError as error:
            return encode(Answer(problem=error.sentence))
        except Exception as error:  # a plug-in may raise anything
            _LOG.exception("speaker failed unexpectedly")
            why = reason_of(error)
            return encode(Answer(problem=Sentence("speaker.failed", {"why": why})))
        return encode(Answer())


class _Answers:
    """Answers requests in one daemon thread, because a plug-in's call may hang."""

    def __init__(self, connection: Connection, answer: Callable[[bytes], bytes], name: str) -> None:
        self._connection = connection
        self._answer = answer
        self._thread = threading.Thread(target=self._run, name=f"{name} answers", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def _run(self) -> None:
        try:
            while True:
                question = self._connection.recv_bytes(_MAX_QUESTION_BYTES)
                self._connection.send_bytes(self._answer(question))
        except (OSError, EOFError):
            pass  # the server has gone, and this process will end


def checked_picture(picture: object) -> Picture:
    """Return the picture if it can be shown; raises `SourceError`."""
    if not isinstance(picture, Picture):
        raise _odd(f"a {type(picture).__name__} that is no Picture")
    i420 = picture.i420
    if not isinstance(i420, np.ndarray) or i420.dtype != np.uint8 or i420.ndim != 2:
        raise _odd("something other than a table of bytes")
    rows, width = i420.shape
    height = rows * 2 // 3
    if rows % 3 or width % 2 or height % 2 or not rows:
        raise _odd(f"{width} by {rows} bytes")
    if width > MAX_WIDTH or height > MAX_HEIGHT:
        raise _odd(f"{width} by {height} pixels")
    if not _is_time(picture.captured_s):
        raise _odd("no time of capture")
    if picture.within_s is not None and not (_is_time(picture.within_s) and picture.within_s >= 0):
        raise _odd("a time of capture that errs by no time")
    return picture


def checked_sound(sound: object) -> Sound:
    """Return the sound if it can be played; raises `SourceError`."""
    samples = sound.samples if isinstance(sound, Sound) else None
    if (
        not isinstance(sound, Sound)
        or not isinstance(samples, np.ndarray)
        or samples.dtype != np.int16
        or samples.ndim not in (1, 2)
        or (samples.ndim == 2 and samples.shape[1] != 2)
        or not 0 < samples.shape[0] <= MAX_SAMPLES
        or not _is_time(sound.captured_s)
    ):
        type_ = getattr(samples, "dtype", type(sound).__name__)
        shape = str(getattr(samples, "shape", "none"))
        raise SourceError(Sentence("microphone.odd", {"type": str(type_), "shape": shape}))
    return sound


def _is_time(value: object) -> bool:
    return isinstance(value, int | float) and math.isfinite(value)


def _odd(what: str) -> SourceError:
    return SourceError(
        Sentence(
            "camera.odd",
            {"what": what, "width": MAX_WIDTH, "height": MAX_HEIGHT},
        )
    )
