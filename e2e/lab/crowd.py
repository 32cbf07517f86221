"""The other viewers of a crowd: they count what they get, at the server's end of the link.

There they load neither the link nor the browser's decoder; they have a process of their own, so
that what they cost is not the server's. As a program: ``python -m e2e.lab.crowd URL HOW NUMBER``
says a line of JSON when all see and hear, another for each line that it is given, and leaves at
the end of its input.
"""

from __future__ import annotations

import asyncio
import json
import sys
import time
from asyncio.subprocess import PIPE
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import aiohttp
from pydantic import BaseModel, ConfigDict

from e2e.bench.errors import BenchError
from e2e.bench.viewer import Offering, Viewer
from e2e.lab.errors import LabError
from e2e.lab.process import CostMeter

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from collections.abc import AsyncIterator

    from e2e.lab.cell import Cell
    from e2e.lab.link import Link

JOINING_AT_ONCE: Final = 4
JOIN_WITHIN_S: Final = 60.0
_ANSWER_WITHIN_S: Final = 10.0
_LEAVE_WITHIN_S: Final = 5.0


class Count(BaseModel):
    """What all of them have got so far, each number for one of them, on CLOCK_MONOTONIC."""

    model_config = ConfigDict(extra="forbid")

    at_s: float
    frames: list[int]
    packets: int
    lost: int
    problem: str | None = None
    """Why there is no crowd."""


@dataclass(slots=True)
class Crowd:
    """The near end."""

    process: Process
    first: Count
    meter: CostMeter

    async def told(self) -> dict[str, float | str]:
        """Return what they got since they were all there; raises `LabError`."""
        last = await _ask(self.process)
        span_s = last.at_s - self.first.at_s
        rates = [
            (after - before) / span_s
            for before, after in zip(self.first.frames, last.frames, strict=True)
        ]
        packets = last.packets - self.first.packets
        lost = last.lost - self.first.lost
        return {
            "crowd.viewers": len(rates),
            "crowd.pictures_per_s_min": min(rates),
            "crowd.pictures_per_s_mean": sum(rates) / len(rates),
            "crowd.lost_share": lost / (packets + lost) if packets + lost > 0 else 0.0,
            "crowd.cpu_share": self.meter.read().cpu_share,
        }


@asynccontextmanager
async def crowd(cell: Cell, link: Link, url: str) -> AsyncIterator[Crowd]:
    """Have all but one of the cell's viewers inside the block; raises `LabError`.

    None for LiveKit, whose viewers join through its own library and not by one offer; nobody plans
    such a cell.
    """
    if cell.system == "livekit":
        raise LabError("a crowd at LiveKit was not built; measure it with one viewer")
    how = "stock" if cell.system == "stock" else "wax"
    process = await link.server.spawn_python(
        ["-m", "e2e.lab.crowd", url.rstrip("/"), how, str(cell.viewers - 1)],
        stdin=PIPE,
        stdout=PIPE,
    )
    try:
        first = await _answer(process, JOIN_WITHIN_S)
        yield Crowd(process, first, CostMeter(process.pid, "the crowd"))
    finally:
        assert process.stdin is not None
        process.stdin.close()
        try:
            await asyncio.wait_for(process.wait(), _LEAVE_WITHIN_S)
        except TimeoutError:
            process.kill()
            await process.wait()


async def _ask(process: Process) -> Count:
    assert process.stdin is not None
    with suppress(ConnectionError):  # then the answer says that it has ended
        process.stdin.write(b"count\n")
        await process.stdin.drain()
    return await _answer(process, _ANSWER_WITHIN_S)


async def _answer(process: Process, within_s: float) -> Count:
    assert process.stdout is not None
    try:
        line = await asyncio.wait_for(process.stdout.readline(), within_s)
    except TimeoutError as error:
        raise LabError(f"the crowd did not answer within {within_s:.0f} s") from error
    if not line:
        raise LabError("the crowd's process has ended; its last words are on standard error")
    count = Count.model_validate_json(line)
    if count.problem is not None:
        raise LabError(f"the crowd did not come together: {count.problem}")
    return count


async def _be_crowd(offering: Offering, number: int) -> None:
    viewers = [Viewer(offering) for _ in range(number)]
    try:
        async with aiohttp.ClientSession() as http:
            for start in range(0, number, JOINING_AT_ONCE):
                some = viewers[start : start + JOINING_AT_ONCE]
                await asyncio.gather(*(viewer.connect(http) for viewer in some))
        _say(_count(viewers))
        while await asyncio.to_thread(sys.stdin.readline):
            _say(_count(viewers))
    except (BenchError, aiohttp.ClientError) as error:
        _say(Count(at_s=0.0, frames=[], packets=0, lost=0, problem=str(error)))
    finally:
        await asyncio.gather(*(viewer.close() for viewer in viewers))


def _count(viewers: list[Viewer]) -> Count:
    counts = [viewer.counts() for viewer in viewers]
    streams = [stream for count in counts for stream in (count.video, count.audio)]
    return Count(
        at_s=time.monotonic(),
        frames=[count.video.frames for count in counts],
        packets=sum(stream.packets for stream in streams),
        lost=sum(stream.lost for stream in streams),
    )


def _say(count: Count) -> None:
    print(json.dumps(count.model_dump()), flush=True)


def main() -> None:
    """Hold a crowd until the input ends."""
    url, how, number = sys.argv[1:]
    wax = how == "wax"
    offering = Offering(url=url + ("/api/offer" if wax else "/offer"), wax=wax)
    asyncio.run(_be_crowd(offering, int(number)))


if __name__ == "__main__":
    main()
