"""Waits, with a limit, for another process or a page, and reports what did not happen."""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

T = TypeVar("T")


async def eventually(
    ask: Callable[[], Awaitable[T]],
    what: str,
    *,
    within_s: float = 10.0,
    every_s: float = 0.1,
) -> T:
    """Ask repeatedly until the answer is true, and return it.

    Raises `AssertionError` with `what` and the last answer when `within_s` have passed.
    """
    deadline_s = time.monotonic() + within_s
    while True:
        answer = await ask()
        if answer:
            return answer
        if time.monotonic() > deadline_s:
            raise AssertionError(f"not within {within_s:g} s: {what} (last answer: {answer!r})")
        await asyncio.sleep(every_s)


async def until(ask: Callable[[], T], what: str, **limits: float) -> T:
    """Wait as `eventually` does for what is known in this process."""

    async def answer() -> T:
        return ask()

    return await eventually(answer, what, **limits)
