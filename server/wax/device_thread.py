"""Runs a device in a thread of its own and reopens it when it fails; for sources and speakers."""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Final, Protocol

import structlog

from wax.errors import SourceError, SpeakerError, reason_of

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.sentence import Sentence

_RETRY_S: Final = 1.0
_STOP_S: Final = 1.0


class Device(Protocol):
    """What the thread needs of a device; either method may raise anything."""

    def open(self) -> None: ...

    def close(self) -> None: ...


class DeviceThread(ABC):
    """Opens a device, uses it until it fails, and reopens it after a second.

    All methods may be called from any thread. None raises.
    """

    def __init__(
        self,
        device: Device,
        clock: Clock,
        *,
        name: str,
        # The problem until it is first opened.
        problem: Sentence | None,
        # The problem once the device has blocked for this long: a hung one cannot report itself.
        hangs: Sentence,
        hangs_after_s: float,
    ) -> None:
        self._device = device
        self._clock = clock
        self._name = name
        self._problem = self._first_problem = problem
        self._hangs = hangs
        self._hangs_after_s = hangs_after_s
        self._log = structlog.get_logger(__name__, device=name)
        self._stopping = threading.Event()
        self._lock = threading.Lock()
        self._busy_since_s: float | None = None
        self._thread: threading.Thread | None = None
        self.failures = 0
        """How often it has failed since the start."""

    @property
    def problem(self) -> Sentence | None:
        """A sentence for people while the device does not work, otherwise None."""
        with self._lock:
            since_s = self._busy_since_s
            hangs = since_s is not None and self._clock.now_s() - since_s > self._hangs_after_s
            if hangs and self._problem in (None, self._first_problem):
                self._note(self._hangs)
            return self._problem

    def start(self) -> None:
        # A daemon: a hung operating system driver must not keep the process alive.
        self._thread = threading.Thread(target=self._run, name=self._name, daemon=True)
        self._thread.start()

    def request_stop(self) -> None:
        """Ask the thread to end, without waiting; `stop` waits for it."""
        self._stopping.set()

    def stop(self) -> None:
        """End the thread and release the device; takes at most 1 s, safe to call twice.

        A thread that hangs in its device is abandoned.
        """
        self.request_stop()
        thread, self._thread = self._thread, None
        if thread is None:
            return
        thread.join(timeout=_STOP_S)
        if thread.is_alive():
            self._log.warning("device's thread does not end; abandoned")

    @abstractmethod
    def _use(self) -> None:
        """Use it until `_stopping`: `_mark_busy` before what may hang, then `_mark_working`."""

    @abstractmethod
    def _failed(self, why: str) -> Sentence:
        """Return the sentence for an error that has none."""

    def _run(self) -> None:
        while not self._stopping.is_set():
            try:
                self._mark_busy()
                self._device.open()
                self._use()
            except (SourceError, SpeakerError) as error:
                self._fail(error.sentence)
            except Exception as error:
                # A plug-in may raise anything; the server keeps running.
                self._log.exception("device failed unexpectedly")
                self._fail(self._failed(reason_of(error)))
            finally:
                self._close()
            self._stopping.wait(_RETRY_S)

    def _mark_busy(self) -> None:
        self._busy_since_s = self._clock.now_s()

    def _mark_working(self) -> None:
        self._busy_since_s = None
        self._tell(None)

    def _fail(self, sentence: Sentence) -> None:
        self.failures += 1
        self._busy_since_s = None
        self._tell(sentence)

    def _close(self) -> None:
        self._busy_since_s = None
        try:
            self._device.close()
        except Exception:
            self._log.exception("device does not close")

    def _tell(self, problem: Sentence | None) -> None:
        with self._lock:
            if problem != self._problem and not self._stopping.is_set():
                self._note(problem)

    def _note(self, problem: Sentence | None) -> None:
        """Store a new problem, or None when it has passed; the lock is held."""
        self._problem = problem
        if problem is None:
            self._log.info("device works")
        else:
            self._log.warning("device has a problem", problem=str(problem))
