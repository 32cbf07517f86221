"""An error's message, for a sentence."""

from __future__ import annotations

import errno

import pytest

from wax.errors import SourceError, reason_of


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (OSError(errno.ENOSPC, "No space left on device", "a.mp4"), "No space left on device"),
        (OSError("no such device"), "no such device"),
        (SourceError("It is unplugged."), "It is unplugged."),
        (TimeoutError(), "TimeoutError"),
    ],
)
def test_an_error_says_why_without_a_number(error: Exception, reason: str) -> None:
    assert reason_of(error) == reason
