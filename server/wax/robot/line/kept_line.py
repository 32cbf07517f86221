"""Keeps a line to a robot open: one thread opens it and writes, another reads.

`RobotLine` is what differs from one kind of line to the next.
"""

from __future__ import annotations

import math
import threading
from abc import ABC, abstractmethod
from contextlib import suppress
from typing import TYPE_CHECKING, ClassVar, Final, Protocol

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.clock import Clock
    from wax.sentence import Sentence

CLOSE_S: Final = 0.8
LONGEST_PAUSE_S: Final = 1.0


class RobotLine(ABC):
    """A line that is opened again and again. One thread calls all methods but `hear`.

    All but `problem` may block, and raise anything if the line is lost.
    """

    hears: ClassVar[bool] = False
    """Whether a second thread calls `hear`."""

    def start(self) -> None:  # noqa: B027 - most need nothing
        """Prepare, before the line is opened for the first time."""

    @abstractmethod
    def open(self, wake: Callable[[], None]) -> None:
        """Open the line; `wake` makes `step` be called at once, from any thread."""

    def begin(self, now_s: float) -> None:  # noqa: B027
        """Begin talking on the open line; nothing is read before this returns."""

    @abstractmethod
    def step(self, now_s: float) -> float:
        """Send what is due; return the latest time of the next call."""

    def hear(self) -> bool:
        """Wait a moment for data and handle it; return whether to call `step` at once."""
        return False

    def leave(self, now_s: float) -> float:  # noqa: ARG002
        """Stop the robot for good; return for how long `step` must still be called to do so."""
        return 0.0

    def last_words(self, error: Exception) -> None:  # noqa: B027
        """Try to stop the robot on a line that has just failed."""

    @abstractmethod
    def close(self) -> None:
        """Close the line, also after it has failed."""

    def end(self) -> None:  # noqa: B027
        """Clean up, after the line was closed for the last time."""

    @abstractmethod
    def problem(self, error: Exception, *, was_open: bool) -> Sentence:
        """Return why the line was lost or, if it was not open, could not be opened."""


class LineUser(Protocol):
    """Who must know when a line is lost."""

    def lost(self, problem: Sentence | None) -> None:
        """Handle that the line was lost, or closed if there is no problem."""
        ...


class KeptLine:
    """One line, kept open from `open` to `close`, and reopened `reopen_s` after a failure."""

    def __init__(
        self,
        name: str,
        line: RobotLine,
        user: LineUser,
        clock: Clock,
        *,
        reopen_s: float,
        close_s: float = CLOSE_S,
    ) -> None:
        self._name = name
        self._line = line
        self._user = user
        self._clock = clock
        self._reopen_s, self._close_s = reopen_s, close_s
        self._news = threading.Event()
        self._closing = threading.Event()
        self._thread: threading.Thread | None = None
        self._left: threading.Thread | None = None
        self._error: Exception | None = None

    @property
    def is_open(self) -> bool:
        """Whether it was opened, and not closed since."""
        return self._thread is not None

    def open(self) -> None:
        """Start opening the line and keep trying; no effect if already started."""
        if self._thread is not None:
            return
        self._closing = threading.Event()
        self._thread = threading.Thread(
            target=self._keep, args=(self._closing, self._left), name=self._name, daemon=True
        )
        self._thread.start()

    def wake(self) -> None:
        """Send what is due now."""
        self._news.set()

    def close(self) -> None:
        """Stop the robot and close the line; takes at most a second, safe to call twice."""
        thread, self._thread = self._thread, None
        if thread is None:
            return
        self._closing.set()
        self._news.set()
        thread.join(self._close_s)
        self._left = thread  # if it hangs, the next one waits for it
        self._user.lost(None)

    def _keep(self, closing: threading.Event, left: threading.Thread | None) -> None:
        if left is not None:
            left.join()
        self._line.start()
        try:
            while not closing.is_set():
                problem = self._use(closing)
                self._user.lost(None if closing.is_set() else problem)
                closing.wait(self._reopen_s)
        finally:
            self._line.end()

    def _use(self, closing: threading.Event) -> Sentence | None:
        """Open the line and use it until it is closed or lost; return why it was lost."""
        try:
            self._line.open(self.wake)
        except Exception as error:  # whatever a port's driver or a name lookup raises
            return self._line.problem(error, was_open=False)
        ended = threading.Event()
        reader = threading.Thread(
            target=self._read, args=(ended,), name=f"{self._name} reader", daemon=True
        )
        try:
            self._line.begin(self._clock.now_s())
            if self._line.hears:
                reader.start()
            self._write(closing)
        except Exception as error:  # as above
            with suppress(Exception):  # often only one direction is lost
                self._line.last_words(error)
            return self._line.problem(error, was_open=True)
        finally:
            ended.set()
            if reader.ident is not None:
                reader.join()
            self._error = None
            with suppress(Exception):
                self._line.close()
        return None

    def _write(self, closing: threading.Event) -> None:
        ends_s = math.inf
        while True:
            self._news.clear()
            if self._error is not None and ends_s == math.inf:
                raise self._error
            now_s = self._clock.now_s()
            if closing.is_set() and ends_s == math.inf:
                ends_s = now_s + self._line.leave(now_s)
            if self._clock.now_s() >= ends_s:
                return
            due_s = min(self._line.step(now_s), ends_s)
            self._news.wait(min(max(0.0, due_s - self._clock.now_s()), LONGEST_PAUSE_S))

    def _read(self, ended: threading.Event) -> None:
        try:
            while not ended.is_set():
                if self._line.hear():
                    self._news.set()
        except Exception as error:  # the writer ends with it and reports it
            self._error = error
            self._news.set()
