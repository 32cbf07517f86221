"""How long a receiver asks us to wait: the header `Retry-After` (RFC 9110, 10.2.3). Pure."""

from __future__ import annotations

from datetime import UTC
from email.utils import parsedate_to_datetime
from typing import Final

LONGEST_S: Final = 300.0
"""The longest wait that is granted: an event expires after ten minutes and needs one more try."""
_MOST_DIGITS: Final = 9


def wait_s(value: str | None, unix_s: float) -> float:
    """Return the seconds to wait from `unix_s`, at most `LONGEST_S`; 0 for an invalid value."""
    text = (value or "").strip()
    if text.isascii() and text.isdigit():
        asked_s = float(text[:_MOST_DIGITS])
    else:
        try:
            at = parsedate_to_datetime(text)
            asked_s = (at if at.tzinfo else at.replace(tzinfo=UTC)).timestamp() - unix_s
        except (ValueError, OverflowError):
            return 0.0
    return min(max(asked_s, 0.0), LONGEST_S)
