"""Which addresses have left an answered offer alone: they come after all others. Pure."""

from __future__ import annotations

from typing import Final

_REMEMBERED_S: Final = 60.0
_MOST: Final = 1024
"""So many addresses are remembered, the newest."""


class Unfollowed:
    """Somebody who connects clears the name of the address: a school's pages fail now and then."""

    def __init__(self) -> None:
        self._left_s: dict[str, float] = {}

    def left(self, address: str, now_s: float) -> None:
        """Note an offer that nobody has followed up."""
        self._left_s.pop(address, None)
        self._left_s[address] = now_s
        if len(self._left_s) > _MOST:
            del self._left_s[next(iter(self._left_s))]

    def came(self, address: str) -> None:
        """Note that somebody has connected."""
        self._left_s.pop(address, None)

    def has_left(self, address: str, now_s: float) -> bool:
        """Whether it has done so within the last minute, and nobody has connected from it since."""
        return now_s - self._left_s.get(address, float("-inf")) < _REMEMBERED_S
