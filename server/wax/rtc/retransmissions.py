"""Which lost packets are sent again: none twice while the first copy may still be on its way. Pure.

Chromium asks for a lost packet every 100 ms, up to ten times (RFC 4585 leaves that to it), and
aiortc answers each time. On a line whose queue is a second long that fills the queue with copies.
"""

from __future__ import annotations

from collections import OrderedDict
from typing import Final

_REMEMBERED: Final = 256
"""Twice as many as a sender keeps for sending again."""


class Retransmissions:
    """Remembers when each packet was last sent again."""

    def __init__(self) -> None:
        self._sent_s: OrderedDict[int, float] = OrderedDict()

    def is_due(self, sequence_number: int, round_trip_s: float | None, now_s: float) -> bool:
        """Tell whether to send this one again now.

        A copy needs a round trip until its receipt can be known; None is an unknown one.
        """
        sent_s = self._sent_s.get(sequence_number)
        return sent_s is None or now_s - sent_s >= (round_trip_s or 0.0)

    def sent(self, sequence_number: int, now_s: float) -> None:
        """Remember that this one has been sent again."""
        self._sent_s[sequence_number] = now_s
        self._sent_s.move_to_end(sequence_number)
        if len(self._sent_s) > _REMEMBERED:
            self._sent_s.popitem(last=False)
