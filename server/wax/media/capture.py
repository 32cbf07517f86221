"""Run one source in a thread of its own, and keep on trying when it fails."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Final, Generic, Protocol, TypeVar

import structlog

from wax.errors import SourceError

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.clock import Clock

_LOG = structlog.get_logger(__name__)

ItemT = TypeVar("ItemT")
ItemT_co = TypeVar("ItemT_co", covariant=True)

_SILENT_S: Final = 3.0
"""A source that blocks this long is reported, although its thread cannot be helped."""

_WATCH_S: Final = 0.25
_STOP_S: Final = 1.0


class _Source(Protocol[ItemT_co]):
    """What `VideoSource` and `AudioSource` have in common."""

    def open(self) -> None: ...

    def read(self) -> ItemT_co: ...

    def close(self) -> None: ...


class Capture(Generic[ItemT]):
    """Opens a source, hands everything it delivers to `sink`, reopens it after a failure.

    `name` is what the source is to people, ``camera`` or ``microphone``. `sink`
    and `on_problem` are called from threads of this object; `on_problem` gets the sentence when
    there is a new problem and None when it has passed. Nothing is raised out of here.
    """

    def __init__(
        self,
        source: _Source[ItemT],
        sink: Callable[[ItemT], None],
        *,
        name: str,
        clock: Clock,
        retry_s: float,
        on_problem: Callable[[str | None], None] | None = None,
    ) -> None:
        self._source = source
        self._sink = sink
        self._name = name
        self._clock = clock
        self._retry_s = retry_s
        self._on_problem = on_problem
        self._stopping = threading.Event()
        self._lock = threading.RLock()  # `on_problem` may look at `problem`
        self._problem: str | None = None
        self._busy_since_s: float | None = None
        self._threads: list[threading.Thread] = []
        self.delivered = 0
        self.failures = 0

    @property
    def problem(self) -> str | None:
        """A sentence for a person while nothing is delivered, else None."""
        self._watch()
        return self._problem

    def start(self) -> None:
        for role, target in (("read", self._run), ("watch", self._run_watch)):
            # Daemons: a driver of the operating system that hangs must not keep the process.
            thread = threading.Thread(target=target, name=f"{self._name}: {role}", daemon=True)
            self._threads.append(thread)
            thread.start()

    def stop(self) -> None:
        """End the threads and release the source; takes at most 1.5 s, safe to call twice.

        A thread that hangs in its device is left behind; it delivers nothing any more.
        """
        self._stopping.set()
        for thread, timeout_s in zip(self._threads, (_STOP_S, 2 * _WATCH_S), strict=False):
            thread.join(timeout=timeout_s)
            if thread.is_alive():
                _LOG.warning("thread does not end, left behind", thread=thread.name)
        self._threads.clear()

    def _run(self) -> None:
        while not self._stopping.is_set():
            try:
                self._deliver()
            except SourceError as error:
                self._fail(str(error))
            except Exception as error:
                # Somebody else's source may raise anything; the robot's server lives on.
                _LOG.exception("source failed unexpectedly", source=self._name)
                self._fail(f"The {self._name} failed: {error or type(error).__name__}")
            finally:
                self._close()
            self._stopping.wait(self._retry_s)

    def _deliver(self) -> None:
        self._busy_since_s = self._clock.now_s()
        self._source.open()
        while not self._stopping.is_set():
            self._busy_since_s = self._clock.now_s()
            item = self._source.read()
            self._busy_since_s = None
            if self._stopping.is_set():
                return
            self.delivered += 1
            self._tell(None)
            self._sink(item)

    def _fail(self, sentence: str) -> None:
        self.failures += 1
        self._busy_since_s = None
        self._tell(sentence)

    def _close(self) -> None:
        self._busy_since_s = None
        try:
            self._source.close()
        except Exception:
            _LOG.exception("source does not close", source=self._name)

    def _run_watch(self) -> None:
        while not self._stopping.wait(_WATCH_S):
            self._watch()

    def _watch(self) -> None:
        since_s = self._busy_since_s
        if since_s is None or self._problem is not None:
            return
        if self._clock.now_s() - since_s > _SILENT_S:
            self._tell(f"The {self._name} delivers nothing; check that it is connected.")

    def _tell(self, problem: str | None) -> None:
        with self._lock:
            if problem == self._problem or self._stopping.is_set():
                return
            self._problem = problem
            if problem is None:
                _LOG.info("source delivers again", source=self._name)
            else:
                _LOG.warning("source has a problem", source=self._name, problem=problem)
            if self._on_problem is None:
                return
            try:
                self._on_problem(problem)
            except Exception:
                _LOG.exception("telling a source's problem failed", source=self._name)
