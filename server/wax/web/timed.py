"""Run a coroutine step by step: each has its turn, and is charged without what it waits for."""

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
    """Run `inner`; each step waits for `enter`.

    `charge` is called after each step with its beginning, by `thread_time`.
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
        except BaseException as raised:  # it is the inner one's
            error = raised
