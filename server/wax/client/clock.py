"""Estimates the server's clock from the fastest of the newest round trips (pure)."""

from __future__ import annotations

from collections import deque
from typing import Final

_REMEMBERED: Final = 32
"""Round trips kept: 6 s of an operator's heartbeats."""


class ServerClock:
    """Aligned by pings: the server's timestamp is taken to be of the middle of the round trip."""

    def __init__(self) -> None:
        self._exchanges: deque[tuple[float, float]] = deque(maxlen=_REMEMBERED)

    def add(self, sent_ms: float, received_ms: float, server_ms: float) -> None:
        """Count one answered ping; the first two times are on this client's clock."""
        round_trip_ms = received_ms - sent_ms
        self._exchanges.append((round_trip_ms, server_ms - (sent_ms + received_ms) / 2))

    @property
    def ahead_ms(self) -> float:
        """How far the server's clock is ahead of this one; 0 before the first exchange."""
        return min(self._exchanges, default=(0.0, 0.0))[1]

    @property
    def one_way_s(self) -> float:
        """Half the shortest of the newest round trips; 0 before the first."""
        return min(self._exchanges, default=(0.0, 0.0))[0] / 2000

    @property
    def error_ms(self) -> float | None:
        """How wrong `ahead_ms` can be at most; None before the first exchange."""
        return self.one_way_s * 1000 if self._exchanges else None
