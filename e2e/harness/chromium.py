"""Launch the system's Chromium, so that no browser is downloaded: here, or at an end of a link."""

from __future__ import annotations

import os
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from playwright.async_api import Error

from e2e.harness.installed import CHROMIUM, installed
from e2e.measure.errors import MeasureError

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Sequence

    from playwright.async_api import Browser, Playwright

    from e2e.link import End
    from e2e.measure.ear import Ear

FLAGS = (
    "--autoplay-policy=no-user-gesture-required",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
    "--disable-quic",
)


async def launch_chromium(
    playwright: Playwright, *more_flags: str, ear: Ear | None = None, **options: Any
) -> Browser:
    """Launch it headless, with sound allowed before any touch, and heard if there is an ear.

    `options` are Playwright's.
    """
    root = hasattr(os, "geteuid") and os.geteuid() == 0
    return await playwright.chromium.launch(
        **{"executable_path": installed(*CHROMIUM), **options},
        headless=True,
        args=[*FLAGS, *more_flags, *(["--no-sandbox"] if root else [])],
        ignore_default_args=None if ear is None else ["--mute-audio"],
        env=None if ear is None else {**os.environ, **ear.variables},
    )


@asynccontextmanager
async def chromium_at(
    end: End, playwright: Playwright, known: Sequence[str], *flags: str, ear: Ear | None = None
) -> AsyncIterator[Browser]:
    """Have it at an end of a link, where it resolves no names but the `known` addresses.

    Nobody answers there, and what it asks for would go over the link. Raises `NotRunError`, or
    `MeasureError` when it does not start.
    """
    rules = "".join(f", EXCLUDE {one}" for one in known)
    flags = (*flags, "--no-sandbox", f"--host-resolver-rules=MAP * ~NOTFOUND{rules}")
    with TemporaryDirectory(prefix="chromium-") as folder:
        program = end.launcher(Path(folder) / "chromium", installed(*CHROMIUM))
        options: dict[str, Any] = {
            "executable_path": program,
            "timeout": 40_000,
            # Ctrl-C is for us alone: the browser is closed when we are ready.
            **dict.fromkeys(("handle_sigint", "handle_sigterm", "handle_sighup"), False),
        }
        try:
            browser = await launch_chromium(playwright, *flags, ear=ear, **options)
        except Error as error:
            raise MeasureError(f"Chromium does not start: {error.message.strip()}") from error
        try:
            yield browser
        finally:
            with suppress(Error):  # it may have ended
                await browser.close()
