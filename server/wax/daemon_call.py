"""Wait for what blocks, such as a name server that hangs, and hold up nobody and no end.

The event loop's own threads are few, which the page's files need too, and a process ends only once
they are free.
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
    """Return what `call` returns in a thread of this name, or raise what it raises."""
    answer: Future[_Found] = Future()
    answer.set_running_or_notify_cancel()  # nobody may be left to hear it

    def run() -> None:
        try:
            answer.set_result(call())
        except Exception as error:
            answer.set_exception(error)

    threading.Thread(target=run, name=name, daemon=True).start()
    return await asyncio.wrap_future(answer)
