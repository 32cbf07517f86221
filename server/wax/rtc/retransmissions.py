"""Decides which lost packets to retransmit: none again while a copy may be in flight. Pure.

Chromium requests a lost packet every 100 ms, up to ten times (RFC 4585 leaves that open), and
aiortc answers each time. On a link with a queue of a second, that fills the queue with copies.
`wax.congestion.sender_side` says which packets are too old to help.
"""

from __future__ import annotations

from typing import Final

from wax.bounded_dict import BoundedDict

_REMEMBERED: Final = 1024
"""How many packets to remember, as many as can be requested."""
_LEAST_S: Final = 0.02
"""The least time between copies, whatever round trip is claimed: libwebrtc requests no sooner (its
NACK module runs every 20 ms)."""
_MOST_COPIES: Final = 5
"""Per packet: at 20 % loss, one in three thousand needs more."""

_FORGOTTEN_S: Final = 10.0
"""After this a number may belong to another packet: numbers wrap after some minutes. Copies are
kept apart by a round trip of up to this."""


class Retransmissions:
    """Remembers when each packet was last retransmitted, and how often."""

    def __init__(self) -> None:
        self._sent = BoundedDict[int, tuple[float, int]](_REMEMBERED)

    def is_due(self, sequence_number: int, round_trip_s: float | None, now_s: float) -> bool:
        """Whether to retransmit this packet now.

        Whether a copy arrived is known only after a round trip (None if unknown).
        """
        sent_s, copies = self._last(sequence_number, now_s)
        wait_s = max(round_trip_s or 0.0, _LEAST_S)
        return copies < _MOST_COPIES and now_s - sent_s >= wait_s

    def sent(self, sequence_number: int, now_s: float) -> None:
        """Record that this packet was retransmitted."""
        _, copies = self._last(sequence_number, now_s)
        self._sent[sequence_number] = now_s, copies + 1

    def _last(self, sequence_number: int, now_s: float) -> tuple[float, int]:
        """Return when the last copy left, and how many there were."""
        last = self._sent.get(sequence_number)
        if last is None or now_s - last[0] > _FORGOTTEN_S:
            return float("-inf"), 0
        return last
