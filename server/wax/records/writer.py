"""Writes in a thread of its own, so that trouble with the file never reaches the event loop.

It uses the standard library's sqlite3: aiosqlite is also a thread, but behind an unbounded queue,
and its callers wait for each result, which nobody here needs.
"""

from __future__ import annotations

import math
import sqlite3
import threading
from collections import deque
from contextlib import closing
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Final

import structlog

from wax.errors import reason_of
from wax.records import file as record_file
from wax.records import schema

if TYPE_CHECKING:
    from pathlib import Path

    from wax.clock import Clock

_LOG = structlog.get_logger(__name__)

GATHER_S: Final = 0.25
"""Statements that arrive within this time are committed together."""
RETRY_S: Final = 5.0
MAX_WAITING: Final = 10_000
"""The most statements that wait while the file cannot be written; the rest is dropped."""
_PRUNE_S: Final = 3600.0
_LOG_S: Final = 60.0
_DAY_MS: Final = 86_400_000

Value = str | int | float | None
Statement = tuple[str, tuple[Value, ...]]


class RecordWriter:
    """Executes statements on the file at `path`, whose rows are kept for `keep_days`."""

    def __init__(self, path: Path, *, keep_days: float, clock: Clock) -> None:
        self._path = path
        self._keep_ms = int(keep_days * _DAY_MS)
        self._clock = clock
        # A statement stays here until it is committed, so that it counts as waiting.
        self._statements: deque[Statement] = deque()
        # Unlike `Queue`, `put` is reentrant: a garbage-collected object may end a session.
        self._news: SimpleQueue[bool] = SimpleQueue()
        self._is_over = False
        self._pruned_s = -math.inf
        self._logged_s = -math.inf
        self._is_failing = False
        self._was_moved = False
        self._thread = threading.Thread(target=self._run, name="records", daemon=True)
        self.dropped = 0

    @property
    def waiting(self) -> int:
        """How many statements are not committed yet."""
        return len(self._statements)

    def start(self) -> None:
        self._thread.start()

    def put(self, sql: str, *values: Value, lasting: bool = False) -> None:
        """Enqueue a statement to be executed within a second; never blocks or raises.

        The queue holds twice as many statements if they are `lasting`.
        """
        if self.waiting < MAX_WAITING * (2 if lasting else 1):
            self._statements.append((sql, values))
            self._news.put(True)
        else:
            self.dropped += 1

    def request_stop(self) -> None:
        self._news.put(False)

    def stop(self, within_s: float = 1.0) -> None:
        """Write what is queued and end; give up after `within_s`."""
        self.request_stop()
        if self._thread.is_alive():
            self._thread.join(within_s)

    def _run(self) -> None:
        while True:
            try:
                with closing(record_file.open_for_writing(self._path)) as file:
                    return self._write_until_stopped(file)
            except (sqlite3.Error, OSError, schema.NotOursError) as error:
                if self._replace_damaged(error):
                    continue
                self._failed(error)
            if self._is_over:
                self.dropped += self.waiting
                return None
            self._wait_for_batch(RETRY_S, RETRY_S)

    def _write_until_stopped(self, file: sqlite3.Connection) -> None:
        while True:
            if self._clock.now_s() - self._pruned_s >= _PRUNE_S:
                schema.prune(file, now_ms=self._clock.wall_ms(), keep_ms=self._keep_ms)
                self._pruned_s = self._clock.now_s()
            self._write(file)
            if self._is_over:
                return
            self._wait_for_batch(_PRUNE_S, GATHER_S)

    def _write(self, file: sqlite3.Connection) -> None:
        batch = list(self._statements)
        if not batch:
            return
        with schema.transaction(file):
            for sql, values in batch:
                try:
                    file.execute(sql, values)
                except (sqlite3.IntegrityError, ValueError, OverflowError) as error:
                    self._refused(error)
        for _ in batch:
            self._statements.popleft()
        if self._is_failing:
            self._is_failing = False
            _LOG.info("records are written again", dropped=self.dropped)

    def _wait_for_batch(self, first_s: float, more_s: float) -> None:
        """Wait up to `first_s` for a statement, and then up to `more_s` for others."""
        deadline_s = self._clock.now_s() + first_s
        has_first = False
        while not self._is_over:
            try:
                goes_on = self._news.get(timeout=max(0.0, deadline_s - self._clock.now_s()))
            except Empty:
                return
            if not goes_on:
                self._is_over = True
                return
            if not has_first:
                has_first = True
                deadline_s = min(deadline_s, self._clock.now_s() + more_s)

    def _replace_damaged(self, error: Exception) -> bool:
        """Replace a damaged file, but only once: a disk that damages its successor is broken."""
        if self._was_moved or not record_file.is_damage(error):
            return False
        self._was_moved = True
        try:
            record_file.move_aside(self._path, self._clock.wall_ms())
        except (sqlite3.Error, OSError) as moving:
            self._failed(moving)
            return False
        return True

    def _failed(self, error: Exception) -> None:
        self._is_failing = True
        self._log_rarely("records cannot be written", error)

    def _refused(self, error: Exception) -> None:
        self.dropped += 1
        self._log_rarely("a record cannot be written", error)

    def _log_rarely(self, what: str, error: Exception) -> None:
        """Log at most one line a minute."""
        if self._clock.now_s() - self._logged_s >= _LOG_S:
            self._logged_s = self._clock.now_s()
            why = reason_of(error)
            _LOG.warning(what, file=str(self._path), error=why, dropped=self.dropped)
