"""Starts and controls a crowd on this machine."""

from __future__ import annotations

from contextlib import AsyncExitStack, asynccontextmanager
from typing import TYPE_CHECKING, Final

import psutil

from e2e.harness.child import child
from e2e.load.crowd.sample import Sample
from e2e.load.process import ProcessMeter, pinned
from e2e.measure.errors import MeasureError

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

    from e2e.harness.child import Child
    from e2e.load.crowd.sample import Offering

_ANSWER_S: Final = 180.0
_LEAVE_S: Final = 10.0
_NICE: Final = 10


class Crowd:
    """Each request raises `MeasureError` if the crowd's process could not carry it out."""

    def __init__(self, process: Child) -> None:
        self.meter = ProcessMeter(process.pid)
        self._process = process

    async def hold(self, number: int) -> None:
        """Return when exactly `number` viewers see and hear."""
        await self._ask("hold", number)

    async def cycle(self, number: int) -> None:
        """Let `number` viewers join and leave once they receive picture and sound."""
        await self._ask("cycle", number)

    async def count(self) -> Sample:
        return await self._ask("count", 0)

    async def _ask(self, verb: str, number: int) -> Sample:
        await self._process.say(f"{verb} {number}")
        try:
            line = await self._process.line(_ANSWER_S)
        except TimeoutError as error:
            raise MeasureError(f"no {verb} by the viewers in {_ANSWER_S:g} s") from error
        sample = Sample.model_validate_json(line)
        if sample.problem is not None:
            raise MeasureError(sample.problem)
        return sample


@asynccontextmanager
async def gathered(
    offering: Offering,
    core: int | None = None,
    *,
    slow: int = 0,
    yields: bool = True,
    through: Callable[[list[str]], list[str]] = list,
) -> AsyncIterator[Crowd]:
    """Run a crowd, at first empty, in the block; on its core it yields to the measuring process.

    If other processes are busy too, a yielding crowd is so slow that a server gives it up. The
    first `slow` viewers are behind a modem each; `through` is as in `child`.
    """
    words = (offering.url, offering.how, slow)
    async with AsyncExitStack() as leaving:
        with pinned(core):
            run = child("e2e.load.crowd", *words, leaves_s=_LEAVE_S, through=through)
            process = await leaving.enter_async_context(run)
        if yields:
            psutil.Process(process.pid).nice(_NICE)
        yield Crowd(process)
