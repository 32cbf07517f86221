"""Runs a blocking call, such as a name lookup that hangs, without delaying anything else.

The event loop's own executor has few threads, which the page's files need too, and the process
cannot end until they are free.
"""

from __future__ import annotations

import asyncio
import threading
from concurrent.futures import Future
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable

_Found = TypeVar("_Found")


async def daemon_call(name: str, call: Callable[[], _Found]) -> _Found:
    """Run `call` in a daemon thread of this name; return its result or raise its exception."""
    answer: Future[_Found] = Future()
    answer.set_running_or_notify_cancel()  # the waiter may be cancelled before the result

    def run() -> None:
        try:
            answer.set_result(call())
        except Exception as error:
            answer.set_exception(error)

    threading.Thread(target=run, name=name, daemon=True).start()
    return await asyncio.wrap_future(answer)
