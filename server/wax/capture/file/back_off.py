"""Decides when an address is opened again, so that a shared camera is not flooded. Pure."""

from __future__ import annotations

from typing import Final

_MOST_S: Final = 15.0
_REFUSED_S: Final = 30.0
"""The pause after a wrong password: many cameras lock a client out after a few attempts."""


class BackOff:
    """Doubles the pause with each failed attempt, up to 15 s; a delivered packet resets it."""

    def __init__(self, first_s: float = 1.0) -> None:
        self._first_s = first_s
        self._failures = 0
        self.until_s = float("-inf")
        """The address is not opened before this time."""

    def failed(self, now_s: float, *, delivered: bool, refused: bool) -> None:
        """Record a failure: after a packet (`delivered`), or for a wrong password (`refused`)."""
        if delivered:
            self._failures = 0
            self.until_s = now_s
            return
        pause_s = min(self._first_s * 2.0**self._failures, _MOST_S)
        self._failures = min(self._failures + 1, 10)
        self.until_s = now_s + (_REFUSED_S if refused else pause_s)
