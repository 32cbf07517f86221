"""Browsers at the browser end of a link."""

from __future__ import annotations

from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Literal

from e2e.browsers import chromium, firefox
from e2e.browsers.window import Browser, Window
from e2e.harness.installed import CHROMIUM, FIREFOX, installed
from e2e.measure.ear import open_ear

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Sequence
    from pathlib import Path

    from e2e.link import Link

__all__ = ["Browser", "Window", "open_browser"]


@asynccontextmanager
async def open_browser(
    name: Literal["chromium", "firefox"], link: Link, origins: Sequence[str], folder: Path
) -> AsyncIterator[Browser]:
    """Have a browser at the browser end, headless, that plays sound without a touch, to an ear.

    To it the `origins` are secure. It resolves no names. `folder`, which is empty, takes what it
    writes. Raises `NotRunError` when there is none, `MeasureError` when it does not start.
    """
    is_firefox = name == "firefox"
    path = installed(*(FIREFOX if is_firefox else CHROMIUM))
    start = firefox.open_firefox if is_firefox else chromium.open_chromium
    async with open_ear() as ear, start(path, link, origins, folder, ear) as browser:
        yield browser
