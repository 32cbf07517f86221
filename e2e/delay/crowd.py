"""The crowd of a cell, at the server's end of the link.

There it loads neither the link nor the browser's decoder.
"""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from e2e.load.crowd.crowd import Crowd
from e2e.load.crowd.sample import Offering

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable

    from e2e.delay.cell import Cell
    from e2e.link import Link


@asynccontextmanager
async def crowd(cell: Cell, link: Link, url: str) -> AsyncIterator[Callable[[], Awaitable[float]]]:
    """Have all but one of the cell's viewers inside the block; raises `MeasureError`.

    Yields what returns the fewest pictures a second that any of those had who are behind no modem.
    LiveKit's viewers join through its own library and not by one offer; nobody plans such a cell.
    """
    offering = Offering(url.rstrip("/"), "stock" if cell.system == "stock" else "wax")
    with Crowd(offering, slow=cell.slow, through=link.server.command) as others:
        await asyncio.to_thread(others.hold, cell.viewers - 1)
        first = await asyncio.to_thread(others.count)

        async def least_per_s() -> float:
            last = await asyncio.to_thread(others.count)
            pairs = list(zip(first.viewers, last.viewers, strict=True))[cell.slow :]
            fewest = min(after.video.frames - before.video.frames for before, after in pairs)
            return fewest / (last.at_s - first.at_s)

        yield least_per_s
