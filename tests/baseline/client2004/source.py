"""The audio server's newest complete media unit, which it gives only once."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True, slots=True)
class Recorder:
    """How the audio server of 4.2 records: an MU is cut from the sound card's fragments.

    `fragment_ms` is how much sound the card delivers at a time, 0 for a card that delivers every
    sample as it comes. `hand_over_ms` is how long the recorder needs from one MU to the next when
    both are in one fragment.
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


class Server(Protocol):
    """The source of the sound: the shared memory of 2004, or its replacement.

    `given` is the number of each MU that left and when, ms; `skipped` the numbers of those that
    never will.
    """

    given: list[tuple[int, float]]
    skipped: list[int]

    def answer_ms(self, asked_ms: float) -> float | None:
        """Give the newest MU not given yet, or wait for the next; return when it leaves.

        None if nothing more is recorded. `asked_ms` never falls, nor is it before the last left.
        """
        ...


class SharedMemory:
    """Holds one MU; the next replaces it, so a client that asks late has missed some (3.3).

    `valid_ms` additionally limits how long an MU may wait. The thesis says the MU's own length, and
    "in other words" until the next is ready. The latter is no limit, and is the default.
    """

    def __init__(self, ready_ms: list[float], valid_ms: float = math.inf) -> None:
        self._ready_ms = ready_ms
        self._valid_ms = valid_ms
        self._next = 0
        self.given: list[tuple[int, float]] = []
        self.skipped: list[int] = []

    def answer_ms(self, asked_ms: float) -> float | None:
        while self._next < len(self._ready_ms):
            leaves_ms = max(asked_ms, self._ready_ms[self._next])
            newest = self._next
            while newest + 1 < len(self._ready_ms) and self._ready_ms[newest + 1] <= leaves_ms:
                newest += 1
            self.skipped += range(self._next, newest)
            self._next = newest + 1
            if leaves_ms - self._ready_ms[newest] <= self._valid_ms:
                self.given.append((newest, leaves_ms))
                return leaves_ms
            self.skipped.append(newest)
        return None
