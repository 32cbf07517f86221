"""Writes from a thread of its own: nothing that happens to the file reaches the event loop.

The standard library's sqlite3 in one thread: aiosqlite is the same thread behind a queue without
bounds, and its caller waits for each answer, which nobody here needs.
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
"""What comes within this time is written together."""
RETRY_S: Final = 5.0
MAX_WAITING: Final = 10_000
"""As much waits while the file cannot be written; the rest is dropped."""
_PRUNE_S: Final = 3600.0
_LOG_S: Final = 60.0
_DAY_MS: Final = 86_400_000

Value = str | int | float | None
Statement = tuple[str, tuple[Value, ...]]


class RecordWriter:
    """Executes statements on the file at `path`; what is in it is kept for `keep_days`."""

    def __init__(self, path: Path, *, keep_days: float, clock: Clock) -> None:
        self._path = path
        self._keep_ms = int(keep_days * _DAY_MS)
        self._clock = clock
        # It leaves here when it is in the file: on its way it is counted, too.
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
        """How much is not written yet."""
        return len(self._statements)

    def start(self) -> None:
        self._thread.start()

    def put(self, sql: str, *values: Value, lasting: bool = False) -> None:
        """Have a statement executed within a second; never waits and never raises.

        While the file cannot be written, twice as many that are `lasting` may wait.
        """
        if self.waiting < MAX_WAITING * (2 if lasting else 1):
            self._statements.append((sql, values))
            self._news.put(True)
        else:
            self.dropped += 1

    def request_stop(self) -> None:
        self._news.put(False)

    def stop(self, within_s: float = 1.0) -> None:
        """Write what waits, and end; gives up after `within_s`."""
        self.request_stop()
        if self._thread.is_alive():
            self._thread.join(within_s)

    def _run(self) -> None:
        while True:
            try:
                with closing(record_file.open_for_writing(self._path)) as file:
                    return self._serve(file)
            except (sqlite3.Error, OSError, schema.NotOursError) as error:
                if self._begins_anew(error):
                    continue
                self._failed(error)
            if self._is_over:
                self.dropped += self.waiting
                return None
            self._gather(RETRY_S, RETRY_S)

    def _serve(self, file: sqlite3.Connection) -> None:
        while True:
            if self._clock.now_s() - self._pruned_s >= _PRUNE_S:
                schema.prune(file, now_ms=self._clock.wall_ms(), keep_ms=self._keep_ms)
                self._pruned_s = self._clock.now_s()
            self._write(file)
            if self._is_over:
                return
            self._gather(_PRUNE_S, GATHER_S)

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

    def _gather(self, first_s: float, more_s: float) -> None:
        """Wait for a statement, and then for others."""
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

    def _begins_anew(self, error: Exception) -> bool:
        """Set a damaged file aside, once: a disk that damages the next one, too, is broken."""
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
        self._tell("records cannot be written", error)

    def _refused(self, error: Exception) -> None:
        self.dropped += 1
        self._tell("a record cannot be written", error)

    def _tell(self, what: str, error: Exception) -> None:
        """Log one line a minute."""
        if self._clock.now_s() - self._logged_s >= _LOG_S:
            self._logged_s = self._clock.now_s()
            why = reason_of(error)
            _LOG.warning(what, file=str(self._path), error=why, dropped=self.dropped)
