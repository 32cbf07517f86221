"""What the audio server has to give at any moment: the newest whole media unit, once."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Recorder:
    """How the audio server of 4.2 records: an MU is cut from the sound card's fragments.

    `fragment_ms` is how much sound the card hands over at a time, 0 for a card that hands over
    every sample as it comes. `hand_over_ms` is how long the recorder needs from one MU to the
    next when both are in what it has just been given.
    """

    fragment_ms: float
    hand_over_ms: float

    def ready_ms(self, mu_ms: float, count: int) -> list[float]:
        """Return when each of the first `count` MUs is complete and can be sent."""
        ready: list[float] = []
        for number in range(count):
            when_ms = (number + 1) * mu_ms
            if self.fragment_ms:
                when_ms = math.ceil(when_ms / self.fragment_ms - 1e-9) * self.fragment_ms
            if ready:
                when_ms = max(when_ms, ready[-1] + self.hand_over_ms)
            ready.append(when_ms)
        return ready


class SharedMemory:
    """Holds one MU; the next replaces it, so a client that asks late has missed some (3.3)."""

    def __init__(self, ready_ms: list[float]) -> None:
        self._ready_ms = ready_ms
        self._next = 0
        self.skipped = 0

    def answer_ms(self, asked_ms: float) -> float | None:
        """Give the newest MU not given yet, or wait for the next; return when it leaves.

        None when nothing more is recorded.
        """
        if self._next >= len(self._ready_ms):
            return None
        leaves_ms = max(asked_ms, self._ready_ms[self._next])
        newest = self._next
        while newest + 1 < len(self._ready_ms) and self._ready_ms[newest + 1] <= leaves_ms:
            newest += 1
        self.skipped += newest - self._next
        self._next = newest + 1
        return leaves_ms
