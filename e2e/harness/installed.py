"""Finds what is installed here; for anything missing the error says what to install."""

from __future__ import annotations

import os
import shutil
from typing import TYPE_CHECKING, Final

from e2e.measure.errors import NotRunError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.measure.ear import Ear

CHROMIUM: Final = (
    "WAX_CHROMIUM",
    (
        *("chromium", "chromium-browser", "google-chrome", "google-chrome-stable"),
        "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    ),
)
FIREFOX: Final = (
    "WAX_FIREFOX",
    ("firefox-esr", "firefox", "/Applications/Firefox.app/Contents/MacOS/firefox"),
)


def installed(variable: str, names: Sequence[str]) -> str:
    """Return the path of a program: the environment's, or the first of the names that exists.

    Raises `NotRunError`.
    """
    named = os.environ.get(variable) or next(filter(None, map(shutil.which, names)), None)
    if named is None:
        raise NotRunError(
            f"there is no {names[0]}; install the package {names[0]}, or set {variable} to its path"
        )
    return named


def needed(ear: Ear | None) -> Ear:
    """Return the ear; raises `NotRunError` without one."""
    if ear is None:
        raise NotRunError("nothing is heard: install the packages pulseaudio and pulseaudio-utils")
    return ear
