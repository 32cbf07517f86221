"""The target, end and source addresses of an attack."""

from __future__ import annotations

import asyncio
import sys
import time
from collections import Counter
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from itertools import cycle
from typing import TYPE_CHECKING, Any

from e2e.harness.child import Child, child
from e2e.measure.errors import NotRunError

if TYPE_CHECKING:
    import random
    from collections.abc import AsyncIterator, Awaitable, Callable, Iterable, Sequence

    from e2e.strangers.intruder import Intruder

    Work = Callable[["Ground"], Awaitable[None]]


@dataclass(slots=True)
class Ground:
    """An attack's port, viewers and end, and the counts of what it has done so far."""

    port: int
    intruders: Sequence[Intruder]
    until_s: float
    chance: random.Random
    account: Counter[str] = field(default_factory=Counter)
    lasted_s: dict[str, list[float | None]] = field(default_factory=dict)
    """How long slow connections were open, by kind; None for those that still are."""

    @property
    def is_over(self) -> bool:
        return time.monotonic() >= self.until_s

    async def ticks(self, every_s: float) -> AsyncIterator[None]:
        """Tick on time until the end; late ticks are not made up for."""
        due_s = time.monotonic()
        while not self.is_over:
            yield
            due_s = max(due_s + every_s, time.monotonic())
            await asyncio.sleep(max(0.0, min(due_s, self.until_s) - time.monotonic()))

    async def turns(self, rate_hz: float) -> AsyncIterator[Intruder]:
        """Yield each viewer at this rate, evenly spread over the period."""
        intruders = cycle(self.intruders)
        async for _ in self.ticks(1 / rate_hz / len(self.intruders)):
            yield next(intruders)


@dataclass(frozen=True, slots=True)
class Attack:
    """`viewers` join before it begins: with a picture if `sees`, from own addresses if `apart`.

    `prepare` is called before that.
    """

    what: str
    work: Work
    viewers: int = 0
    sees: bool = False
    apart: bool = False
    prepare: Callable[[], object] = bool


async def together(works: Iterable[Awaitable[Any]]) -> None:
    """Run all of them; one that is refused or times out stops none of the others."""
    for result in await asyncio.gather(*works, return_exceptions=True):
        if isinstance(result, BaseException) and not isinstance(result, OSError | TimeoutError):
            raise result


def address(number: int) -> str:
    """Return a loopback address that nothing else uses; `number` counts from 0."""
    return f"127.0.{1 + number // 250}.{2 + number % 250}"


@asynccontextmanager
async def strangers(module: str, *arguments: object) -> AsyncIterator[Child]:
    """Run a module of this folder; it is ready when the block begins.

    Raises `NotRunError` where only 127.0.0.1 is the loopback, as on macOS.
    """
    if sys.platform != "linux":
        raise NotRunError("this needs the whole of 127.0.0.0/8, which only Linux has")
    async with child(f"e2e.strangers.{module}", *arguments) as found:
        await found.line()
        yield found
