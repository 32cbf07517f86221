"""A log handler that never blocks: whoever logs may be the loop that keeps the robot safe."""

from __future__ import annotations

import io
import logging
import os
import select
import threading
import traceback
from queue import SimpleQueue
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Callable

MAX_WAITING: Final = 1000
"""Lines that wait for whoever reads them; more are left out."""
_LONGEST_CHARS: Final = 10_000
"""What is printed without an end of line counts as a line from here on."""
_END_S: Final = 0.3
"""How long the end waits for the last lines to be read."""


class QueuedHandler(logging.Handler):
    """Writes lines to a descriptor from a thread of its own, so that logging never blocks.

    A terminal that is paused or a pipe that nobody reads keeps that thread waiting and nobody else.
    Lines beyond `MAX_WAITING` are dropped, which one more line tells once all others are written.
    `close` waits for what is still to be written, but not for long.

    The `QueueHandler` of the standard library complains of a full queue on standard error, which is
    what may block, and its `QueueListener` waits without a limit at the end. Nor does this use
    `sys.stderr`: Python aborts at its end when a thread is stuck in there.
    """

    def __init__(self, descriptor: int) -> None:
        super().__init__()
        self._descriptor = descriptor
        # Unlike `Queue` it may be put to again within a put: an object that is collected may log.
        self._lines: SimpleQueue[str | None] = SimpleQueue()
        self._dropped = 0
        self._told = 0
        self._thread = threading.Thread(target=self._write_all, name="log", daemon=True)
        self._thread.start()

    def emit(self, record: logging.LogRecord) -> None:
        try:
            line = self.format(record)
        except Exception:
            line = f"a log line cannot be written: {traceback.format_exc()}"
        if self._lines.qsize() < MAX_WAITING:
            self._lines.put(line)
        else:
            self._dropped += 1

    def close(self) -> None:
        self._lines.put(None)
        self._thread.join(_END_S)
        super().close()

    def _write_all(self) -> None:
        while (line := self._lines.get()) is not None:
            self._write(line)
            dropped = self._dropped
            if dropped > self._told and self._lines.empty():
                self._write(self.format(_missing(dropped - self._told)))
                self._told = dropped

    def _write(self, line: str) -> None:
        rest = memoryview(line.encode(errors="backslashreplace") + b"\n")
        while rest:
            try:
                rest = rest[os.write(self._descriptor, rest) :]
            except BlockingIOError:  # another program has made the terminal so
                select.select([], [self._descriptor], [])
            except OSError:
                return  # it is closed; there is nobody to tell


class PrintedLines(io.TextIOBase):
    """A stream for programs that print: each line goes to `log`, so that printing never blocks."""

    def __init__(self, log: Callable[[str], None]) -> None:
        self._log = log
        self._begun = ""

    def write(self, text: str) -> int:
        *lines, self._begun = (self._begun + text).split("\n")
        if len(self._begun) > _LONGEST_CHARS:
            lines.append(self._begun)
            self._begun = ""
        for line in filter(None, lines):
            self._log(line)
        return len(text)


def _missing(count: int) -> logging.LogRecord:
    return logging.makeLogRecord(
        {
            "name": __name__,
            "levelno": logging.WARNING,
            "levelname": "WARNING",
            "msg": "%d log lines are missing: nobody read them in time",
            "args": (count,),
        }
    )
