"""How long a receiver can make us wait."""

from __future__ import annotations

import pytest

from wax.hooks.retry_after import LONGEST_S, wait_s

NOW_S = 784111777.0
"""Sun, 06 Nov 1994 08:49:37 GMT."""


@pytest.mark.parametrize(
    ("value", "seconds"),
    [
        (None, 0.0),
        ("", 0.0),
        ("30", 30.0),
        ("-5", 0.0),
        ("soon", 0.0),
        ("9" * 5000, LONGEST_S),
        ("Sun, 06 Nov 1994 08:50:37 GMT", 60.0),
        ("Sun, 06 Nov 1994 08:40:00 GMT", 0.0),
        ("Fri, 31 Dec 9999 23:59:59 GMT", LONGEST_S),
        ("Sun, 99 Nov 1994 08:50:37 GMT", 0.0),
    ],
)
def test_seconds_and_dates_are_bounded(value: str | None, seconds: float) -> None:
    """A wait is at most `LONGEST_S`; an invalid value or a time past is no wait."""
    assert wait_s(value, NOW_S) == seconds
