"""A log handler that never blocks: its caller may be the control loop."""

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
"""How many lines may wait to be written; more are dropped."""
_LONGEST_CHARS: Final = 10_000
"""Printed text without a newline is cut into lines of this length."""
_END_S: Final = 0.3
"""How long `close` waits for the last lines to be written."""


class QueuedHandler(logging.Handler):
    """Writes lines to a descriptor from its own thread, so that logging never blocks.

    A paused terminal, or a pipe that nobody reads, blocks only that thread. Lines beyond
    `MAX_WAITING` are dropped, and a later line gives their number. `close` waits briefly for lines
    still to be written.

    The standard library's `QueueHandler` reports a full queue on standard error, which may be what
    blocks, and its `QueueListener` waits at the end without limit. `sys.stderr` is avoided because
    Python aborts on exit while a thread is stuck in it.
    """

    def __init__(self, descriptor: int) -> None:
        super().__init__()
        self._descriptor = descriptor
        # Unlike `Queue`, `put` is reentrant: a garbage-collected object may log.
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
            except BlockingIOError:  # another program made the terminal non-blocking
                select.select([], [self._descriptor], [])
            except OSError:
                return  # the descriptor is closed, and there is nowhere to report that


class PrintedLines(io.TextIOBase):
    """A stream for `print`: each line goes to `log`, so that printing never blocks."""

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
            "msg": "%d log lines are missing: they could not be written in time",
            "args": (count,),
        }
    )
