"""Systems under test, at the server's end of a link."""

from __future__ import annotations

from typing import TYPE_CHECKING

from e2e.delay.systems import wax
from e2e.delay.systems.peers import LiveKit
from e2e.delay.systems.served import PORT, Served, serving
from e2e.peers.livekit.installation import find_client, find_server

if TYPE_CHECKING:
    from contextlib import AbstractAsyncContextManager
    from pathlib import Path

    from e2e.delay.cell import Cell
    from e2e.link import Link


def start(cell: Cell, link: Link, folder: Path) -> AbstractAsyncContextManager[Served]:
    """Serve the cell's system inside the block; it is stopped afterwards, killed if needed.

    `folder` gets its configuration and log. Raises `NotRunError` if it cannot run here, and
    `MeasureError` with the end of its log if it does not become healthy.
    """
    match cell.system:
        case "stock":
            arguments = ["-m", "e2e.peers.stock", "0.0.0.0", str(PORT), cell.size]
            return serving(Served, cell.system, link.server, folder, arguments)
        case "livekit" | "livekit-whip":
            how = "whip" if cell.system == "livekit-whip" else "sdk"
            find_server()
            find_client()
            place = ["--host", link.server.address, "--port", str(PORT)]
            arguments = ["-m", "e2e.peers.livekit", "--how", how, "--size", cell.size, *place]
            return serving(LiveKit, cell.system, link.server, folder, arguments)
    return wax.start(cell, link, folder)
