"""Waits, with a limit, for another process or a page, and reports what did not happen."""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING, TypeVar

import aiohttp

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

T = TypeVar("T")
_IN_TIME = aiohttp.ClientTimeout(10)


async def eventually(
    ask: Callable[[], Awaitable[T]], what: str, *, within_s: float = 10.0, every_s: float = 0.05
) -> T:
    """Ask repeatedly until the answer is true, and return it.

    Raises `AssertionError` with `what` and the last answer when `within_s` have passed.
    """
    answer = await _answer(ask, within_s, every_s)
    assert answer, f"not within {within_s:g} s: {what} (last answer: {answer!r})"
    return answer


async def happens(
    ask: Callable[[], Awaitable[object]], *, within_s: float, every_s: float = 0.05
) -> bool:
    """Return whether the answer becomes true in time, as soon as it does."""
    return bool(await _answer(ask, within_s, every_s))


async def _answer(ask: Callable[[], Awaitable[T]], within_s: float, every_s: float) -> T:
    """Return the first true answer, or the last one."""
    deadline_s = time.monotonic() + within_s
    while True:
        answer = await ask()
        if answer or time.monotonic() > deadline_s:
            return answer
        await asyncio.sleep(every_s)


async def until(ask: Callable[[], T], what: str, **limits: float) -> T:
    """Wait, as `eventually` does, for a state of this process."""

    async def answer() -> T:
        return ask()

    return await eventually(answer, what, **limits)


async def answers(url: str) -> bool:
    """Return whether a server answers there, and reports itself healthy."""
    try:
        async with aiohttp.ClientSession(timeout=_IN_TIME) as http, http.get(url) as response:
            return response.status == 200
    except (aiohttp.ClientError, TimeoutError):
        return False
