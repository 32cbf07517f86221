"""Link and browser, kept from cell to cell as long as that changes nothing."""

from __future__ import annotations

import asyncio
import tempfile
from contextlib import AsyncExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Final

from e2e.browsers import open_browser
from e2e.delay.names import profile
from e2e.delay.plan import changes
from e2e.delay.systems import origin
from e2e.link import Link

if TYPE_CHECKING:
    from e2e.browsers import Browser
    from e2e.delay.cell import Cell

CLEAR_WITHIN_S: Final = 30.0


class Stage:
    """``link`` and ``browser`` are there from `set_for` on, until `clear`."""

    link: Link
    browser: Browser

    def __init__(self) -> None:
        self._open: AsyncExitStack | None = None
        self._for: tuple[str, str, int] | None = None

    async def set_for(self, cell: Cell) -> None:
        """Have what this cell needs; what stands is kept where it is that.

        Raises `LinkError`, `NotRunError` or `MeasureError`, and then nothing stands.
        """
        wanted = (cell.profile, cell.browser, cell.repeat)
        if self._open is not None and self._for == wanted:
            return
        await self.clear()
        network = profile(cell.profile)
        network = network.model_copy(update={"seed": network.seed + cell.repeat})
        async with AsyncExitStack() as opening:
            folder = Path(opening.enter_context(tempfile.TemporaryDirectory(prefix="wax-lab-")))
            self.link = await opening.enter_async_context(Link(network))
            self.browser = await opening.enter_async_context(
                open_browser(cell.browser, self.link, [origin(self.link)], folder)
            )
            self._open = opening.pop_all()
        # After its changes a link is another one; None is what no cell wants.
        self._for = None if changes(cell.profile) else wanted

    async def clear(self) -> None:
        """Take it all away; a browser that does not go is ended with its link."""
        opened, self._open, self._for = self._open, None, None
        if opened is not None:
            await asyncio.wait_for(opened.aclose(), CLEAR_WITHIN_S)
