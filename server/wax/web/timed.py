"""What a coroutine costs the event loop, step by step, without what it waits for."""

from __future__ import annotations

import time
from types import coroutine
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine, Generator

_T = TypeVar("_T")


@coroutine
def timed(
    inner: Coroutine[Any, Any, _T], charge: Callable[[float], None]
) -> Generator[Any, Any, _T]:
    """Run `inner`; `charge` is called after each step with its beginning, by `thread_time`."""
    value: Any = None
    error: BaseException | None = None
    while True:
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
