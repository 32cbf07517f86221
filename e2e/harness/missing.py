"""Handles missing tools: a skipped test in a person's run, a failure in CI."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, NoReturn

import pytest

if TYPE_CHECKING:
    from e2e.measure.ear import Ear


def missing(what_to_do: str) -> NoReturn:
    """Skip with a sentence that says what to install; fail where ``CI`` is set."""
    if os.environ.get("CI", "").lower() in {"1", "true", "yes"}:
        pytest.fail(f"nothing is skipped in CI: {what_to_do}", pytrace=False)
    pytest.skip(what_to_do)


def needed(ear: Ear | None) -> Ear:
    """Return the ear; skip without one."""
    return ear or missing("nothing is heard: install the packages pulseaudio and pulseaudio-utils")
