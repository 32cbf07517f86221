"""A child process that a thread starts again whenever it ends, with pauses that double."""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING

import structlog

from wax.errors import reason_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.robot.process.child_process import ChildProcess
    from wax.sentence import Sentence

_LOG = structlog.get_logger(__name__)


@dataclass(frozen=True, slots=True)
class RestartPauses:
    """The pause doubles with each restart, until a process has run for `steady_s`."""

    first_s: float
    last_s: float
    steady_s: float


class KeptProcess(ABC):
    """Keeps one process running; a subclass spawns it, watches it and hears why it ended.

    `_lock` guards `_child`. Only the thread calls the abstract methods, without the lock but for
    `_dismiss`.
    """

    def __init__(self, name: str, now_s: Callable[[], float], pauses: RestartPauses) -> None:
        self._name = name
        self._now_s = now_s
        self._pauses = pauses
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None
        self._closing = threading.Event()
        self._is_abandoned = False
        self._child: ChildProcess | None = None

    @abstractmethod
    def _spawn(self) -> ChildProcess:
        """Start a process; raises `OSError`."""

    @abstractmethod
    def _watch(self, child: ChildProcess, closing: threading.Event) -> Sentence | None:
        """Wait for its end; return a sentence if it must be ended, None once it has ended."""

    @abstractmethod
    def _dismiss(self, child: ChildProcess) -> None:
        """Tell it to end."""

    @abstractmethod
    def _not_started(self, why: str) -> Sentence: ...

    @abstractmethod
    def _ended(self, status: int) -> Sentence:
        """Return why it ended by itself; the exit status is negative for a signal."""

    @abstractmethod
    def _lost(self, problem: Sentence, *, is_over: bool) -> None:
        """Hear why it is gone, before another is started; none is if it `is_over`."""

    def _start(self) -> None:
        """Start the thread; no effect while it keeps a process."""
        with self._lock:
            if self._thread is not None and not self._closing.is_set():
                return
            self._closing = threading.Event()
            self._thread = threading.Thread(
                target=self._keep, args=(self._closing,), name=self._name, daemon=True
            )
            self._thread.start()

    def _end(self, within_s: float) -> bool:
        """Tell the process to end, and wait for that; return whether it has. Safe to call twice."""
        with self._lock:
            self._closing.set()
            thread, child = self._thread, self._child
            if child is not None:
                self._dismiss(child)
        if thread is not None:
            thread.join(within_s)
        return thread is None or not thread.is_alive()

    def _kill(self) -> None:
        with self._lock:
            if self._child is not None:
                self._child.kill()

    def _keep(self, closing: threading.Event) -> None:
        pause_s = self._pauses.first_s
        while not closing.is_set():
            began_s = self._now_s()
            problem = self._attend(closing)
            if closing.is_set():
                self._lost(problem, is_over=True)
                return
            _LOG.warning(f"restarting the {self._name}", problem=str(problem))
            self._lost(problem, is_over=False)
            if self._now_s() - began_s >= self._pauses.steady_s:
                pause_s = self._pauses.first_s
            closing.wait(pause_s)
            pause_s = min(self._pauses.last_s, pause_s * 2.0)

    def _attend(self, closing: threading.Event) -> Sentence:
        """Start a process and watch it until its end; return why it ended."""
        try:
            child = self._spawn()
        except OSError as error:
            return self._not_started(reason_of(error))
        with self._lock:
            self._child = child
            if closing.is_set():
                self._dismiss(child)
        problem = self._watch(child, closing)
        with self._lock:
            if self._child is child:
                self._child = None
        status = 0 if self._is_abandoned else child.end()  # an abandoned one runs on
        return problem or self._ended(status)
