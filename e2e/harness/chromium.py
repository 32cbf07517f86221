"""Find and launch the system's Chromium, so that no browser is downloaded."""

from __future__ import annotations

import os
import shutil
from typing import TYPE_CHECKING

from e2e.harness.missing import missing

if TYPE_CHECKING:
    from playwright.async_api import Browser, Playwright

    from e2e.measure.ear import Ear

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
MAC_PATH = "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome"
FLAGS = (
    "--autoplay-policy=no-user-gesture-required",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
    "--disable-quic",
)


def find_chromium() -> str:
    """Path of the browser: ``WAX_CHROMIUM``, else one of the usual names."""
    named = os.environ.get("WAX_CHROMIUM")
    if named:
        return named
    path = next(filter(None, map(shutil.which, (*NAMES, MAC_PATH))), None)
    return path or missing(
        "no Chromium found: install the package chromium, or set WAX_CHROMIUM to its path"
    )


async def launch_chromium(
    playwright: Playwright, *more_flags: str, ear: Ear | None = None
) -> Browser:
    """Launch it headless, with sound allowed before any touch, and heard if there is an ear."""
    root = hasattr(os, "geteuid") and os.geteuid() == 0
    return await playwright.chromium.launch(
        executable_path=find_chromium(),
        headless=True,
        args=[*FLAGS, *more_flags, *(["--no-sandbox"] if root else [])],
        ignore_default_args=None if ear is None else ["--mute-audio"],
        env=None if ear is None else {**os.environ, **ear.variables},
    )
