"""Aligns the clocks of a page, of this machine's processes, and Unix time."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from wax.clock import SystemClock

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

_TRIES: Final = 40


@dataclass(frozen=True, slots=True, order=True)
class PageClock:
    """CLOCK_MONOTONIC is `ahead_s` more than the page's ``performance.now()``, ± `error_s`."""

    error_s: float
    ahead_s: float

    def monotonic_s(self, page_ms: float) -> float:
        return page_ms / 1000 + self.ahead_s


async def page_clock(evaluate: Callable[[str], Awaitable[Any]]) -> PageClock:
    """Ask the page for its time; half the shortest round trip bounds the error."""
    clocks = []
    for _ in range(_TRIES):
        before_s = time.monotonic()
        page_s = float(await evaluate("performance.now()")) / 1000
        after_s = time.monotonic()
        clocks.append(PageClock((after_s - before_s) / 2, (before_s + after_s) / 2 - page_s))
    return min(clocks)


def unix_ms(monotonic_s: float) -> float:
    """Return Unix time at a moment of `time.monotonic`; pages, cards and the ear use it, too."""
    return SystemClock().wall_ms() + (monotonic_s - time.monotonic()) * 1000
