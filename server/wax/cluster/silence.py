"""When a server that reports each second counts as gone. Pure."""

from __future__ import annotations

from typing import Final

SILENT_S: Final = 3.3
"""A media server reports each second; one that has missed three is gone. aiortc alone would notice
after half a minute."""


class Silence:
    """Judged by two looks in a row, between which the reports that wait are read.

    A process that stood still itself sends again before it has read what came meanwhile.
    """

    def __init__(self) -> None:
        self._was_silent = False

    def is_certain(self, unheard_s: float) -> bool:
        """Look: `unheard_s` is for how long nothing was heard of what was sent."""
        is_silent = unheard_s > SILENT_S
        was_silent, self._was_silent = self._was_silent, is_silent
        return is_silent and was_silent
