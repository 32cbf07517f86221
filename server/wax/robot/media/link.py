"""The server's end of one sense: it asks, and waits for the answer with a timeout."""

from __future__ import annotations

import threading
import time
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


class MediaProcessLink:
    """Asks the current media process. Call `ask` from one thread, the other methods from any.

    `silent` is the problem to report if a process stops answering.
    """

    def __init__(self, silent: Sentence) -> None:
        self._silent = silent
        self._news = threading.Condition()
        self._connection: Connection | None = None
        self._memory: PictureMemory | None = None
        self._problem = STARTING
        self._asked: bytes | None = None
        self.answered_s = float("-inf")
        """When the newest answer arrived, by `time.monotonic`."""
        self.silent_since_s: float | None = None
        """Since when questions have gone unanswered although the process runs; None if not."""

    def attach(self, connection: Connection, memory: int | None) -> None:
        """Direct further questions to this process."""
        with self._news:
            self._connection, self._asked, self.silent_since_s = connection, None, None
            self._memory = None if memory is None else PictureMemory(memory)
            self._problem = STARTING
            self._news.notify_all()

    def detach(self, problem: Sentence) -> None:
        """Drop the connection to a process that has ended; the last reference closes it."""
        with self._news:
            self._connection, self._memory, self._asked = None, None, None
            self._problem = problem
            self._news.notify_all()

    @property
    def memory(self) -> PictureMemory | None:
        return self._memory

    def ask(self, question: bytes, within_s: float) -> tuple[Answer, bytes]:
        """Return the answer and what follows it; raises `SenseError`.

        An unanswered question is not repeated, and its late answer is not taken for another's.
        """
        end_s = time.monotonic() + within_s
        connection = self._wait_for_process(end_s)
        try:
            if self._asked not in (None, question):
                self._receive(connection, end_s)
            if self._asked is None:
                connection.send_bytes(question)
                self._asked = question
            answer, payload = self._receive(connection, end_s)
        except (OSError, EOFError, ProtocolError):
            # The supervisor will soon report why the process has ended.
            self._wait_for_end(connection, end_s + _REASON_S)
            raise SenseError(self._problem) from None
        if answer.problem is not None and answer.problem.code == self._silent.code:
            self.silent_since_s = self.silent_since_s or time.monotonic()
        else:
            self.silent_since_s = None
        if answer.problem is not None:
            raise SenseError(answer.problem)
        self.answered_s = time.monotonic()
        return answer, payload

    def _wait_for_process(self, end_s: float) -> Connection:
        with self._news:
            self._news.wait_for(
                lambda: self._connection is not None, max(0.0, end_s - time.monotonic())
            )
            if self._connection is None:
                raise SenseError(self._problem)
            return self._connection

    def _wait_for_end(self, connection: Connection, end_s: float) -> None:
        with self._news:
            self._news.wait_for(
                lambda: self._connection is not connection, max(0.0, end_s - time.monotonic())
            )

    def _receive(self, connection: Connection, end_s: float) -> tuple[Answer, bytes]:
        while not connection.poll(_LOOK_S):
            if self._connection is not connection:
                raise EOFError
            if time.monotonic() >= end_s:
                raise SenseError(self._problem)
        data = connection.recv_bytes(MAX_ANSWER_BYTES)
        self._asked = None
        self._problem = self._silent
        return decode(data)
