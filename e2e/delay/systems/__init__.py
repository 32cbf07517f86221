"""Systems under test, at the server's end of a link."""

from __future__ import annotations

from typing import TYPE_CHECKING

from e2e.delay.names import PEERS
from e2e.delay.systems import peers, wax

if TYPE_CHECKING:
    from contextlib import AbstractAsyncContextManager
    from pathlib import Path

    from e2e.delay.cell import Cell
    from e2e.delay.systems.served import Served
    from e2e.link import Link


def start(cell: Cell, link: Link, folder: Path) -> AbstractAsyncContextManager[Served]:
    """Serve the cell's system inside the block; it is stopped afterwards, killed if needed.

    `folder` takes its configuration and log. Raises `NotRunError` when it cannot run here,
    `MeasureError` with the end of its log when it does not get healthy.
    """
    if cell.system in PEERS:
        return peers.start(cell, link, folder)
    return wax.start(cell, link, folder)
