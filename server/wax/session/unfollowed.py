"""Which addresses abandoned an answered offer: they rank behind all others. Pure."""

from __future__ import annotations

from typing import Final

_REMEMBERED_S: Final = 60.0
_MOST: Final = 1024
"""Only this many addresses are remembered, the newest."""


class Unfollowed:
    """A connection clears its address: of a school's many pages some fail now and then."""

    def __init__(self) -> None:
        self._left_s: dict[str, float] = {}

    def record(self, address: str, now_s: float) -> None:
        """Record that an answered offer was abandoned."""
        self._left_s.pop(address, None)
        self._left_s[address] = now_s
        if len(self._left_s) > _MOST:
            del self._left_s[next(iter(self._left_s))]

    def clear(self, address: str) -> None:
        """Forget an address from which somebody has connected."""
        self._left_s.pop(address, None)

    def has_recent(self, address: str, now_s: float) -> bool:
        """Whether it abandoned one within the last minute, with no connection since."""
        return now_s - self._left_s.get(address, float("-inf")) < _REMEMBERED_S
