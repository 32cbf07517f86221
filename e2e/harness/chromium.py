"""Launches the system's Chromium, here or at an end of a link, so that no browser is downloaded."""

from __future__ import annotations

import json
import os
from contextlib import asynccontextmanager, contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from playwright.async_api import Error

from e2e.harness.installed import CHROMIUM, installed
from e2e.measure.errors import MeasureError

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator, Sequence

    from playwright.async_api import Browser, BrowserContext, Playwright

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
    """Launch it headless, with sound allowed before any touch, and recorded if there is an ear.

    `options` are Playwright's.
    """
    return await playwright.chromium.launch(**_launching(more_flags, ear, options))


def _launching(flags: Sequence[str], ear: Ear | None, options: dict[str, Any]) -> dict[str, Any]:
    root = hasattr(os, "geteuid") and os.geteuid() == 0
    return {
        "executable_path": options.get("executable_path") or installed(*CHROMIUM),
        "headless": True,
        "args": [*FLAGS, *flags, *(["--no-sandbox"] if root else [])],
        "ignore_default_args": None if ear is None else ["--mute-audio"],
        "env": None if ear is None else {**os.environ, **ear.variables},
    } | options


@asynccontextmanager
async def talkers_chromium(
    playwright: Playwright, origin: str, *flags: str, ear: Ear | None = None, **options: Any
) -> AsyncIterator[BrowserContext]:
    """Open a context of somebody who has let the page of `origin` use the microphone for good.

    Playwright's own permission would apply to every frame, whatever the page's policy says.
    """
    with TemporaryDirectory(prefix="chromium-") as folder:
        default = Path(folder) / "Default"
        default.mkdir()
        allowed = {"media_stream_mic": {f"{origin},*": {"setting": 1}}}
        profile = {"profile": {"content_settings": {"exceptions": allowed}}}
        (default / "Preferences").write_text(json.dumps(profile), encoding="utf-8")
        context = await playwright.chromium.launch_persistent_context(
            folder, **_launching(flags, ear, options)
        )
        try:
            yield context
        finally:
            with suppress(Error):  # it may have ended
                await context.close()


@contextmanager
def at_end(end: End, known: Sequence[str]) -> Iterator[tuple[Sequence[str], dict[str, Any]]]:
    """Yield the flags and options of a browser at an end of a link, however it is launched.

    It resolves no names but the `known` addresses: nobody answers there, and its requests would go
    over the link.
    """
    rules = "".join(f", EXCLUDE {one}" for one in known)
    with TemporaryDirectory(prefix="chromium-") as folder:
        program = end.launcher(Path(folder) / "chromium", installed(*CHROMIUM))
        yield (
            ("--no-sandbox", f"--host-resolver-rules=MAP * ~NOTFOUND{rules}"),
            {
                "executable_path": program,
                "timeout": 40_000,
                # Ctrl-C is for us alone: the browser is closed when we are ready.
                **dict.fromkeys(("handle_sigint", "handle_sigterm", "handle_sighup"), False),
            },
        )


@asynccontextmanager
async def chromium_at(
    end: End, playwright: Playwright, known: Sequence[str], *flags: str, ear: Ear | None = None
) -> AsyncIterator[Browser]:
    """Launch it at an end of a link; see `at_end`.

    Raises `NotRunError`, or `MeasureError` if it does not start.
    """
    with at_end(end, known) as (more, options):
        try:
            browser = await launch_chromium(playwright, *flags, *more, ear=ear, **options)
        except Error as error:
            raise MeasureError(f"Chromium does not start: {error.message.strip()}") from error
        try:
            yield browser
        finally:
            with suppress(Error):  # it may have ended
                await browser.close()
