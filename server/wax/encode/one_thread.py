"""Runs calls that may hang in a separate thread, which is abandoned when one does."""

from __future__ import annotations

import queue
import threading
from typing import TYPE_CHECKING, Generic, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable

ResultT = TypeVar("ResultT")


class OneThread:
    """Runs one call after another; the thread starts with the first."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._calls: queue.SimpleQueue[_Call[object] | None] = queue.SimpleQueue()
        self._thread: threading.Thread | None = None

    def call(self, function: Callable[[], ResultT], timeout_s: float) -> ResultT:
        """Return what `function` returns, or raise what it raises; `TimeoutError` if it hangs.

        Do not call this again after a timeout or after `end`.
        """
        if self._thread is None:
            # A daemon, because a hung call must not keep the process alive.
            self._thread = threading.Thread(
                target=_run, args=(self._calls,), name=self._name, daemon=True
            )
            self._thread.start()
        call = _Call(function)
        self._calls.put(call)  # type: ignore[arg-type]  # only its result has another type
        return call.wait(timeout_s)

    def end(self) -> None:
        """Let the thread end once it is idle; safe to call twice."""
        self._calls.put(None)


class _Call(Generic[ResultT]):
    def __init__(self, function: Callable[[], ResultT]) -> None:
        self._function = function
        self._done = threading.Event()
        self._result: list[ResultT] = []
        self._error: BaseException | None = None

    def run(self) -> None:
        try:
            self._result.append(self._function())
        except BaseException as error:  # raised again in `wait`
            self._error = error
        self._done.set()

    def wait(self, timeout_s: float) -> ResultT:
        if not self._done.wait(timeout_s):
            raise TimeoutError("it does not answer")
        if self._error is not None:
            raise self._error
        return self._result[0]


def _run(calls: queue.SimpleQueue[_Call[object] | None]) -> None:
    while True:
        call = calls.get()
        if call is None:
            return
        call.run()
        del call  # it refers to the caller, which must not be kept alive here
