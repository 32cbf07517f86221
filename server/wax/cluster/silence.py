"""Decides when a media server that reports each second counts as gone. Pure."""

from __future__ import annotations

from typing import Final

SILENT_S: Final = 3.3
"""A server that has missed three of its reports, one a second, is gone; aiortc would notice only
after half a minute."""


class Silence:
    """Requires two silent checks in a row, between which pending reports are read.

    After a pause of our own process, the first check comes before the reports received meanwhile
    are read.
    """

    def __init__(self) -> None:
        self._was_silent = False

    def is_certain(self, unheard_s: float) -> bool:
        """Check once; `unheard_s` is the time since the last report."""
        is_silent = unheard_s > SILENT_S
        was_silent, self._was_silent = self._was_silent, is_silent
        return is_silent and was_silent
