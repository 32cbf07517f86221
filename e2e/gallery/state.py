"""One state of the page: how it comes about, and what the page says in it."""

from __future__ import annotations

from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from e2e.gallery.scene import Scene, scene
from e2e.gallery.views import COMPUTER, PHONE

if TYPE_CHECKING:
    import re
    from collections.abc import AsyncIterator, Awaitable, Callable

    from playwright.async_api import Browser, Locator, Page

    from e2e.gallery.views import Device

_SAYS_WITHIN_MS: Final = 15_000.0


@dataclass(frozen=True, slots=True)
class State:
    """`tell` brings it about, by what a person or the world does, never by the page's inside.

    The state is reached when the page `says` so: words that are seen, or what `shows` finds.
    `has_stop`: the Stop button belongs to this state.
    """

    key: str
    title: str
    tell: Callable[[Scene], Awaitable[None]]
    says: re.Pattern[str]
    shows: Callable[[Page], Locator] | None = None
    has_stop: bool = True
    devices: tuple[Device, ...] = (COMPUTER, PHONE)

    def mark(self, page: Page) -> Locator:
        """Find what tells that the page is in this state."""
        if self.shows is not None:
            return self.shows(page)
        return page.get_by_text(self.says).locator("visible=true").first

    @asynccontextmanager
    async def reached(self, browser: Browser, device: Device) -> AsyncIterator[Scene]:
        """Have the page in this state; raises `AssertionError` or Playwright's `Error`."""
        async with scene(browser, device) as stage:
            await self.tell(stage)
            await self.mark(stage.viewer.page).wait_for(state="visible", timeout=_SAYS_WITHIN_MS)
            yield stage
