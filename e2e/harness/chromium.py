"""Launch the system's Chromium, so that no browser is downloaded."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from e2e.harness.installed import CHROMIUM, installed

if TYPE_CHECKING:
    from playwright.async_api import Browser, Playwright

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
    playwright: Playwright, *more_flags: str, ear: Ear | None = None
) -> Browser:
    """Launch it headless, with sound allowed before any touch, and heard if there is an ear."""
    root = hasattr(os, "geteuid") and os.geteuid() == 0
    return await playwright.chromium.launch(
        executable_path=installed(*CHROMIUM),
        headless=True,
        args=[*FLAGS, *more_flags, *(["--no-sandbox"] if root else [])],
        ignore_default_args=None if ear is None else ["--mute-audio"],
        env=None if ear is None else {**os.environ, **ear.variables},
    )
