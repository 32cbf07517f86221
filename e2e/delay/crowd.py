"""The near end of a crowd, at the server's end of the link.

There it loads neither the link nor the browser's decoder.
"""

from __future__ import annotations

import asyncio
from asyncio.subprocess import PIPE
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from e2e.load.crowd.sample import Request, Sample
from e2e.measure.errors import MeasureError

if TYPE_CHECKING:
    from asyncio.subprocess import Process
    from collections.abc import AsyncIterator

    from e2e.delay.cell import Cell
    from e2e.link import Link

JOIN_WITHIN_S: Final = 40.0
JOIN_EACH_S: Final = 0.5
"""More for each of them."""
_ANSWER_WITHIN_S: Final = 10.0
_LEAVE_WITHIN_S: Final = 5.0


@dataclass(slots=True)
class Crowd:
    """`first` is what they had when all were there; the first `slow` are behind a modem each."""

    process: Process
    first: Sample
    slow: int

    async def least_per_s(self) -> float:
        """Return the fewest pictures a second that any of the others got; raises `MeasureError`."""
        last = await _ask(self.process, Request(verb="count"), _ANSWER_WITHIN_S)
        pairs = list(zip(self.first.viewers, last.viewers, strict=True))[self.slow :]
        fewest = min(after.video.frames - before.video.frames for before, after in pairs)
        return fewest / (last.at_s - self.first.at_s)


@asynccontextmanager
async def crowd(cell: Cell, link: Link, url: str) -> AsyncIterator[Crowd]:
    """Have all but one of the cell's viewers inside the block; raises `MeasureError`.

    None for LiveKit, whose viewers join through its own library and not by one offer; nobody plans
    such a cell.
    """
    how = "stock" if cell.system == "stock" else "wax"
    number = cell.viewers - 1
    process = await link.server.spawn_python(
        ["-m", "e2e.load.crowd", url.rstrip("/"), how, str(cell.slow)], stdin=PIPE, stdout=PIPE
    )
    try:
        hold = Request(verb="hold", number=number)
        first = await _ask(process, hold, JOIN_WITHIN_S + JOIN_EACH_S * number)
        yield Crowd(process, first, cell.slow)
    finally:
        assert process.stdin is not None
        process.stdin.close()
        try:
            await asyncio.wait_for(process.wait(), _LEAVE_WITHIN_S)
        except TimeoutError:
            process.kill()
            await process.wait()


async def _ask(process: Process, request: Request, within_s: float) -> Sample:
    assert process.stdin is not None
    assert process.stdout is not None
    with suppress(ConnectionError):  # then the answer says that it has ended
        process.stdin.write(request.model_dump_json().encode() + b"\n")
        await process.stdin.drain()
    try:
        line = await asyncio.wait_for(process.stdout.readline(), within_s)
    except TimeoutError as error:
        raise MeasureError(f"the crowd did not answer within {within_s:.0f} s") from error
    if not line:
        raise MeasureError("the crowd's process has ended; its last words are on standard error")
    sample = Sample.model_validate_json(line)
    if sample.problem is not None:
        raise MeasureError(f"the crowd did not come together: {sample.problem}")
    return sample
