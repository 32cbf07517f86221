"""Which lost packets to send again: none twice while the first copy may be in flight. Pure.

Chromium requests a lost packet every 100 ms, up to ten times (RFC 4585 leaves that open), and
aiortc answers each time. On a link with a queue of a second that fills the queue with copies.
"""

from __future__ import annotations

from collections import OrderedDict
from typing import Final

_REMEMBERED: Final = 256
"""How many retransmissions to remember."""


class Retransmissions:
    """Remembers when each packet was last sent again."""

    def __init__(self) -> None:
        self._sent_s: OrderedDict[int, float] = OrderedDict()

    def is_due(self, sequence_number: int, round_trip_s: float | None, now_s: float) -> bool:
        """Whether to send this packet again now.

        A copy's receipt is known only after a round trip (None if unknown).
        """
        sent_s = self._sent_s.get(sequence_number)
        return sent_s is None or now_s - sent_s >= (round_trip_s or 0.0)

    def sent(self, sequence_number: int, now_s: float) -> None:
        """Record that this packet was sent again."""
        self._sent_s[sequence_number] = now_s
        self._sent_s.move_to_end(sequence_number)
        if len(self._sent_s) > _REMEMBERED:
            self._sent_s.popitem(last=False)
