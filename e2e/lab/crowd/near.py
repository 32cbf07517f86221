"""The lab's side of the crowd's process."""

from __future__ import annotations

import asyncio
from asyncio.subprocess import PIPE
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from pydantic import BaseModel, ConfigDict

from e2e.lab.process import CostMeter
from e2e.measure.errors import MeasureError

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from collections.abc import AsyncIterator

    from e2e.lab.cell import Cell
    from e2e.lab.link import Link

JOIN_WITHIN_S: Final = 40.0
JOIN_EACH_S: Final = 0.5
"""More for each of them."""
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
    slow: int = 0
    """The first of them so many are behind a modem each."""
    feedbacks: int = 0
    """Transport-wide feedback packets that all of them sent."""
    repeats_asked: int = 0
    keyframes_asked: int = 0


@dataclass(slots=True)
class Crowd:
    """The near end."""

    process: Process
    first: Count
    meter: CostMeter

    async def told(self) -> dict[str, float | str]:
        """Return what they got since they were all there; raises `MeasureError`."""
        last = await _ask(self.process)
        span_s = last.at_s - self.first.at_s
        rates = [
            (after - before) / span_s
            for before, after in zip(self.first.frames, last.frames, strict=True)
        ]
        packets = last.packets - self.first.packets
        lost = last.lost - self.first.lost
        slow, quick = rates[: last.slow], rates[last.slow :]
        found: dict[str, float | str] = {
            "crowd.viewers": len(rates),
            "crowd.slow": last.slow,
            "crowd.pictures_per_s_min": min(quick),
            "crowd.pictures_per_s_mean": sum(quick) / len(quick),
            "crowd.lost_share": lost / (packets + lost) if packets + lost > 0 else 0.0,
            "crowd.packets_per_s": packets / span_s,
            "crowd.feedbacks_per_s": (last.feedbacks - self.first.feedbacks) / span_s,
            "crowd.repeats_asked_per_s": (last.repeats_asked - self.first.repeats_asked) / span_s,
            "crowd.keyframes_asked_per_s": (
                (last.keyframes_asked - self.first.keyframes_asked) / span_s
            ),
            "crowd.cpu_share": self.meter.read().cpu_share,
        }
        if slow:
            found["crowd.slow_pictures_per_s_min"] = min(slow)
            found["crowd.slow_pictures_per_s_mean"] = sum(slow) / len(slow)
        return found


@asynccontextmanager
async def crowd(cell: Cell, link: Link, url: str) -> AsyncIterator[Crowd]:
    """Have all but one of the cell's viewers inside the block; raises `MeasureError`.

    None for LiveKit, whose viewers join through its own library and not by one offer; nobody plans
    such a cell.
    """
    if cell.system == "livekit":
        raise MeasureError("a crowd at LiveKit was not built; measure it with one viewer")
    how = "stock" if cell.system == "stock" else "wax"
    number = cell.viewers - 1
    process = await link.server.spawn_python(
        ["-m", "e2e.lab.crowd", url.rstrip("/"), how, str(number), str(cell.slow)],
        stdin=PIPE,
        stdout=PIPE,
    )
    try:
        first = await _answer(process, JOIN_WITHIN_S + JOIN_EACH_S * number)
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
        raise MeasureError(f"the crowd did not answer within {within_s:.0f} s") from error
    if not line:
        raise MeasureError("the crowd's process has ended; its last words are on standard error")
    count = Count.model_validate_json(line)
    if count.problem is not None:
        raise MeasureError(f"the crowd did not come together: {count.problem}")
    return count
