"""Browsers at the browser end of a link."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from e2e.lab.browsers.chromium import open_chromium
from e2e.lab.browsers.firefox import open_firefox
from e2e.lab.browsers.window import Browser, Window

if TYPE_CHECKING:
    from collections.abc import Sequence
    from contextlib import AbstractAsyncContextManager
    from pathlib import Path

    from e2e.lab.link import Link

__all__ = ["Browser", "Window", "open_browser"]


def open_browser(
    name: Literal["chromium", "firefox"], link: Link, origins: Sequence[str], folder: Path
) -> AbstractAsyncContextManager[Browser]:
    """Have a browser at the browser end, headless, that plays sound without a touch.

    To it the `origins` are secure. It resolves no names. `folder`, which is empty, takes what it
    writes. Raises `NotRunError` when there is none, `MeasureError` when it does not start.
    """
    if name == "firefox":
        return open_firefox(link, origins, folder)
    return open_chromium(link, origins, folder)
