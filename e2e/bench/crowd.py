"""Many viewers in a process of their own, so that what they cost is not the server's."""

from __future__ import annotations

import asyncio
import contextlib
import multiprocessing
import time
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import aiohttp

from e2e.bench.process import ProcessMeter, pinned
from e2e.bench.viewer import Offering, Viewer, ViewerCounts
from e2e.measure.errors import MeasureError

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from multiprocessing.connection import Connection
    from types import TracebackType

ANSWER_TIMEOUT_S = 180.0
JOINING_AT_ONCE = 4


@dataclass(frozen=True, slots=True)
class Command:
    """`hold`: have just so many viewers; `cycle`: so many more join and leave; `count`; `end`."""

    verb: Literal["hold", "cycle", "count", "end"]
    number: int = 0


@dataclass(frozen=True, slots=True)
class Sample:
    """What everybody has received so far, on CLOCK_MONOTONIC."""

    at_s: float
    viewers: tuple[ViewerCounts, ...]


class Crowd:
    """The near end: `with Crowd(offering, core) as crowd: crowd.hold(8); crowd.count()`.

    Every method raises `MeasureError` when the far end could not do it.
    """

    def __init__(self, offering: Offering, core: int | None = None) -> None:
        context = multiprocessing.get_context("spawn")
        self._end, far_end = context.Pipe()
        self._process = context.Process(target=_main, args=(far_end, offering), daemon=True)
        with pinned(core):
            self._process.start()
        far_end.close()
        if self._process.pid is None:
            raise MeasureError("the viewers' process did not start")
        self.meter = ProcessMeter(self._process.pid)

    def __enter__(self) -> Crowd:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with contextlib.suppress(OSError):  # it may have gone already
            self._end.send(Command("end"))
            self._process.join(timeout=10.0)
        self._process.kill()
        self._process.join()
        self._end.close()

    def hold(self, number: int) -> None:
        """Return when exactly `number` viewers see and hear."""
        self._ask(Command("hold", number))

    def cycle(self, number: int) -> None:
        """Let `number` viewers join and, once they see and hear, leave."""
        self._ask(Command("cycle", number))

    def count(self) -> Sample:
        sample = self._ask(Command("count"))
        if not isinstance(sample, Sample):
            raise MeasureError("the viewers' process gave no count")
        return sample

    def _ask(self, command: Command) -> object:
        try:
            self._end.send(command)
            if not self._end.poll(ANSWER_TIMEOUT_S):
                raise MeasureError(f"the viewers did not {command.verb} in {ANSWER_TIMEOUT_S:g} s")
            answer = self._end.recv()
        except (OSError, EOFError) as error:
            raise MeasureError(
                f"the viewers' process ended while asked to {command.verb}"
            ) from error
        if isinstance(answer, MeasureError):
            raise answer
        return answer


class _CrowdProcess:
    """The far end: holds the viewers and does as told."""

    def __init__(self, offering: Offering, http: aiohttp.ClientSession) -> None:
        self._offering = offering
        self._http = http
        self._viewers: list[Viewer] = []

    async def do(self, command: Command) -> object:
        match command.verb:
            case "hold":
                await self._hold(command.number)
            case "cycle":
                await self._cycle(command.number)
            case "count":
                counts = tuple(viewer.counts() for viewer in self._viewers)
                return Sample(at_s=time.monotonic(), viewers=counts)
            case "end":
                await self._hold(0)
        return None

    async def _hold(self, number: int) -> None:
        leaving, self._viewers = self._viewers[number:], self._viewers[:number]
        await asyncio.gather(*(viewer.close() for viewer in leaving))
        while len(self._viewers) < number:
            some = min(JOINING_AT_ONCE, number - len(self._viewers))
            self._viewers += await asyncio.gather(*(self._join() for _ in range(some)))

    async def _cycle(self, number: int) -> None:
        for start in range(0, number, JOINING_AT_ONCE):
            some = min(JOINING_AT_ONCE, number - start)
            viewers = await asyncio.gather(*(self._join() for _ in range(some)))
            await asyncio.gather(*(viewer.close() for viewer in viewers))

    async def _join(self) -> Viewer:
        viewer = Viewer(self._offering)
        try:
            await viewer.connect(self._http)
        except BaseException:
            await viewer.close()
            raise
        return viewer


@asynccontextmanager
async def _crowd(offering: Offering) -> AsyncIterator[_CrowdProcess]:
    async with aiohttp.ClientSession() as http:
        yield _CrowdProcess(offering, http)


async def _serve(end: Connection[Any, Command], offering: Offering) -> None:
    loop = asyncio.get_running_loop()
    async with _crowd(offering) as crowd:
        while True:
            command = await loop.run_in_executor(None, end.recv)
            try:
                end.send(await crowd.do(command))
            except (MeasureError, aiohttp.ClientError) as error:
                end.send(MeasureError(str(error)))
            if command.verb == "end":
                return


def _main(end: Connection[Any, Command], offering: Offering) -> None:
    # Either means that the benchmark has ended.
    with contextlib.suppress(EOFError, KeyboardInterrupt):
        asyncio.run(_serve(end, offering))
