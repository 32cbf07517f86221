"""Handles missing tools: a skipped test in a person's run, a failure in CI."""

from __future__ import annotations

import os
from typing import NoReturn

import pytest


def missing(what_to_do: str) -> NoReturn:
    """Skip with a sentence that says what to install; fail where ``CI`` is set."""
    if os.environ.get("CI", "").lower() in {"1", "true", "yes"}:
        pytest.fail(f"nothing is skipped in CI: {what_to_do}", pytrace=False)
    pytest.skip(what_to_do)
