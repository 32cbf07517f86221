"""How soon an address is opened again: a camera that others share must not be flooded. Pure."""

from __future__ import annotations

from typing import Final

_MOST_S: Final = 15.0
_REFUSED_S: Final = 30.0
"""After a wrong password: many cameras lock out who tries a few times."""


class BackOff:
    """Doubles the pause with each opening in vain, up to 15 s; what has delivered begins anew."""

    def __init__(self, first_s: float = 1.0) -> None:
        self._first_s = first_s
        self._failures = 0
        self.until_s = float("-inf")
        """Nothing is opened before."""

    def failed(self, now_s: float, *, delivered: bool, refused: bool) -> None:
        """Note that it has ended; `delivered` if anything had come, `refused` for its password."""
        if delivered:
            self._failures = 0
            self.until_s = now_s
            return
        pause_s = min(self._first_s * 2.0**self._failures, _MOST_S)
        self._failures = min(self._failures + 1, 10)
        self.until_s = now_s + (_REFUSED_S if refused else pause_s)
