"""The server's end of one sense: it asks, and waits for the answer with a timeout."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from wax.errors import ProtocolError
from wax.robot.media.messages import MAX_ANSWER_BYTES, Answer, decode
from wax.robot.media.picture_memory import PictureMemory
from wax.sentence import Sentence

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

STARTING: Final = Sentence("media.starting")
_LOOK_S: Final = 0.1
_REASON_S: Final = 0.5


class SenseError(Exception):
    """There was no answer, or it reports the problem in `sentence`."""

    def __init__(self, sentence: Sentence) -> None:
        super().__init__(str(sentence))
        self.sentence = sentence


@dataclass(slots=True, eq=False)
class _Process:
    """The current process; `asked` is the question that it has not answered yet."""

    connection: Connection
    asked: bytes | None = None
    has_answered: bool = False


class MediaProcessLink:
    """Asks the current media process. Call `ask` from one thread, the other methods from any.

    `silent` is the problem to report if a process stops answering.
    """

    def __init__(self, silent: Sentence) -> None:
        self._silent = silent
        self._news = threading.Condition()
        self._process: _Process | None = None
        self._memory: PictureMemory | None = None
        self._ended = STARTING
        self.answered_s = float("-inf")
        """When the newest answer arrived, by `time.monotonic`."""
        self.silent_since_s: float | None = None
        """Since when questions have gone unanswered although the process runs; None if not."""

    def attach(self, connection: Connection, memory: int | None) -> None:
        """Direct further questions to this process."""
        with self._news:
            self._process, self.silent_since_s = _Process(connection), None
            self._memory = None if memory is None else PictureMemory(memory)
            self._news.notify_all()

    def detach(self, problem: Sentence) -> None:
        """Drop the connection to a process that has ended; the last reference closes it."""
        with self._news:
            self._process, self._memory, self._ended = None, None, problem
            self._news.notify_all()

    @property
    def memory(self) -> PictureMemory | None:
        return self._memory

    def ask(self, question: bytes, within_s: float) -> tuple[Answer, bytes]:
        """Return the answer and what follows it; raises `SenseError`.

        An unanswered question is not repeated, and its late answer is not taken for another's.
        """
        end_s = time.monotonic() + within_s
        process = self._wait_for_process(end_s)
        try:
            if process.asked not in (None, question):
                self._receive(process, end_s)
            if process.asked is None:
                process.connection.send_bytes(question)
                process.asked = question
            answer, payload = self._receive(process, end_s)
        except (OSError, EOFError, ProtocolError):
            # The supervisor will soon report why the process has ended.
            self._wait_for_end(process, end_s + _REASON_S)
            raise SenseError(self._problem) from None
        if answer.problem is not None and answer.problem.code == self._silent.code:
            self.silent_since_s = self.silent_since_s or time.monotonic()
        else:
            self.silent_since_s = None
        if answer.problem is not None:
            raise SenseError(answer.problem)
        self.answered_s = time.monotonic()
        return answer, payload

    @property
    def _problem(self) -> Sentence:
        """Why there is no answer now."""
        process = self._process
        if process is None:
            return self._ended
        return self._silent if process.has_answered else STARTING

    def _wait_for_process(self, end_s: float) -> _Process:
        with self._news:
            self._news.wait_for(
                lambda: self._process is not None, max(0.0, end_s - time.monotonic())
            )
            if self._process is None:
                raise SenseError(self._problem)
            return self._process

    def _wait_for_end(self, process: _Process, end_s: float) -> None:
        with self._news:
            self._news.wait_for(
                lambda: self._process is not process, max(0.0, end_s - time.monotonic())
            )

    def _receive(self, process: _Process, end_s: float) -> tuple[Answer, bytes]:
        while not process.connection.poll(_LOOK_S):
            if self._process is not process:
                raise EOFError
            if time.monotonic() >= end_s:
                raise SenseError(self._problem)
        data = process.connection.recv_bytes(MAX_ANSWER_BYTES)
        process.asked, process.has_answered = None, True
        return decode(data)
