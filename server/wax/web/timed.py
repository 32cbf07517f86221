"""Run a coroutine step by step: each step waits for its turn, and only its own time is charged."""

from __future__ import annotations

import time
from types import coroutine
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine, Generator

_T = TypeVar("_T")


@coroutine
def timed(
    inner: Coroutine[Any, Any, _T],
    charge: Callable[[float], None],
    enter: Callable[[], Coroutine[Any, Any, None]],
) -> Generator[Any, Any, _T]:
    """Run `inner`; each step awaits `enter` first.

    `charge` is called after each step with the `time.thread_time()` at which it began.
    """
    value: Any = None
    error: BaseException | None = None
    while True:
        try:
            yield from enter().__await__()
        except BaseException as raised:
            error = raised
        began_s = time.thread_time()
        try:
            waits_for = inner.send(value) if error is None else inner.throw(error)
        except StopIteration as end:
            result: _T = end.value
            return result
        finally:
            charge(began_s)
        value = error = None
        try:
            value = yield waits_for
        except BaseException as raised:  # meant for `inner`
            error = raised
