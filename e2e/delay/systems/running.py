"""A system at the server's end of the link, whichever it is."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from playwright.async_api import Page

    from e2e.delay.systems.served import Served
    from e2e.link import Link

PORT: Final = 8080
"""Each link has its own network, so it is free."""


class Running:
    """Inside its block it serves; `url` is what the browser opens."""

    def __init__(self, served: Served) -> None:
        self.url = served.url
        self.pid = served.pid
        """Of the server; it may have children."""
        self._served = served

    async def opened(self, window: Page) -> None:
        """Do what a person does to hear, and for ``operator`` to drive, once the page is open.

        Returns when the page says so. Raises `MeasureError` when it does not.
        """

    async def told(self) -> dict[str, float | str]:
        """Return what the server says of itself. Raises `MeasureError` when it has ended."""
        self._served.check()
        return {}


def origin(link: Link) -> str:
    """Return where a page of any system comes from."""
    return f"http://{link.server.address}:{PORT}"
