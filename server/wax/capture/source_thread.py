"""Run one source in its own thread, and reopen it when it fails."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Final, Generic, Protocol, TypeVar

import structlog

from wax.errors import SourceError
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.clock import Clock

_LOG = structlog.get_logger(__name__)

ItemT = TypeVar("ItemT")
ItemT_co = TypeVar("ItemT_co", covariant=True)

_SILENT_S: Final = 3.0
"""A source that blocks for this long is reported."""

_STOP_S: Final = 1.0


class _Source(Protocol[ItemT_co]):
    """The common part of `VideoSource` and `AudioSource`."""

    def open(self) -> None: ...

    def read(self) -> ItemT_co: ...

    def close(self) -> None: ...


class SourceThread(Generic[ItemT]):
    """Opens a source, passes everything it delivers to `sink`, and reopens it after a failure.

    `name` is ``camera``, which a name of its own may follow, or ``microphone``. `sink` is
    called from this object's thread; the other methods may be called from any thread. Nothing here
    raises.
    """

    def __init__(
        self,
        source: _Source[ItemT],
        sink: Callable[[ItemT], None],
        *,
        name: str,
        clock: Clock,
        retry_s: float,
    ) -> None:
        self._source = source
        self._sink = sink
        self._name = name
        self._hears = name == "microphone"
        self._clock = clock
        self._retry_s = retry_s
        self._stopping = threading.Event()
        self._lock = threading.Lock()
        self._problem: Sentence | None = None
        self._busy_since_s: float | None = None
        self._thread: threading.Thread | None = None
        self._failures = 0

    @property
    def problem(self) -> Sentence | None:
        """A sentence for people while nothing is delivered, else None.

        A hung source cannot report itself; it counts as failed after 3 s without a sign of life.
        """
        with self._lock:
            since_s = self._busy_since_s
            hangs = since_s is not None and self._clock.now_s() - since_s > _SILENT_S
            if hangs and self._problem is None:
                self._note(Sentence("microphone.silent" if self._hears else "camera.silent"))
            return self._problem

    @property
    def failures(self) -> int:
        """How often the source or the sink has failed since the start."""
        return self._failures

    def start(self) -> None:
        # A daemon: a hung operating system driver must not keep the process alive.
        self._thread = threading.Thread(target=self._run, name=self._name, daemon=True)
        self._thread.start()

    def request_stop(self) -> None:
        """Ask the thread to end, and return at once; `stop` then waits for it."""
        self._stopping.set()

    def stop(self) -> None:
        """End the thread and release the source; takes at most 1 s, safe to call twice.

        A thread that hangs in its device is abandoned and delivers nothing more.
        """
        self.request_stop()
        thread, self._thread = self._thread, None
        if thread is None:
            return
        thread.join(timeout=_STOP_S)
        if thread.is_alive():
            _LOG.warning("source thread does not end; abandoned", source=self._name)

    def _run(self) -> None:
        while not self._stopping.is_set():
            try:
                self._deliver()
            except SourceError as error:
                self._fail(error.sentence)
            except Exception as error:
                # A plug-in may raise anything; the server keeps running.
                _LOG.exception("source failed unexpectedly", source=self._name)
                self._fail(
                    Sentence(
                        "microphone.failed" if self._hears else "camera.failed",
                        {"why": str(error) or type(error).__name__},
                    )
                )
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
            self._tell(None)
            self._sink(item)

    def _fail(self, sentence: Sentence) -> None:
        self._failures += 1
        self._busy_since_s = None
        self._tell(sentence)

    def _close(self) -> None:
        self._busy_since_s = None
        try:
            self._source.close()
        except Exception:
            _LOG.exception("source does not close", source=self._name)

    def _tell(self, problem: Sentence | None) -> None:
        with self._lock:
            if problem != self._problem and not self._stopping.is_set():
                self._note(problem)

    def _note(self, problem: Sentence | None) -> None:
        """Store a new problem, or None when it has passed; the lock is held."""
        self._problem = problem
        if problem is None:
            _LOG.info("source delivers again", source=self._name)
        else:
            _LOG.warning("source has a problem", source=self._name, problem=str(problem))
