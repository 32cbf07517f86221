"""The stock aiortc server, see `e2e.peers.stock`."""

from __future__ import annotations

from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from e2e.lab.systems.film import film
from e2e.lab.systems.running import PORT
from e2e.lab.systems.served import Served, serving

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from e2e.lab.browsers import Window
    from e2e.lab.cell import Cell
    from e2e.lab.link import Link


class Stock:
    def __init__(self, served: Served) -> None:
        self.url = served.url
        self.pid = served.pid
        self._served = served

    async def opened(self, window: Window) -> None:
        """There is nothing to press: the page plays by itself."""

    async def told(self) -> dict[str, float | str]:
        self._served.check()
        return {}


@asynccontextmanager
async def start(cell: Cell, link: Link, folder: Path) -> AsyncIterator[Stock]:
    """See `e2e.lab.systems.start`."""
    arguments = ["-m", "e2e.peers.stock", "--host", "0.0.0.0", "--port", str(PORT)]
    if cell.content == "talking-head":
        arguments += ["--media", str(await film())]
    async with serving("stock", link, folder, arguments) as served:
        yield Stock(served)
