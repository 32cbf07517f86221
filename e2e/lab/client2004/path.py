"""How long an MU is on its way: synthetic delays, or a trace of sending and arrival times."""

from __future__ import annotations

import math
from bisect import bisect_left
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Protocol

from e2e.lab.client2004.errors import TraceError

if TYPE_CHECKING:
    from collections.abc import Iterable
    from random import Random


class Path(Protocol):
    """A TCP stream: nothing is lost, everything arrives in order (the client sees to that)."""

    def delay_ms(self, at_ms: float, chance: Random) -> float:
        """Return the time from asking to having it all, for what is asked for at `at_ms`."""
        ...


@dataclass(frozen=True, slots=True)
class SyntheticPath:
    """Delays between `least_ms` and `most_ms`, and now and then one up to `spike_ms`."""

    least_ms: float
    most_ms: float
    spike_chance: float
    spike_ms: float

    def delay_ms(self, at_ms: float, chance: Random) -> float:
        if chance.random() < self.spike_chance:
            return chance.uniform(self.most_ms, self.spike_ms)
        return chance.uniform(self.least_ms, self.most_ms)


class RecordedPath:
    """Replays a trace of (sent, arrived) in ms, over and over; way there and back alike."""

    def __init__(self, trace: list[tuple[float, float]]) -> None:
        """Raise `TraceError` unless the sending times rise and nothing arrives before it left."""
        if len(trace) < 2:
            raise TraceError("The trace has fewer than two lines; record more.")
        if not all(math.isfinite(when) for line in trace for when in line):
            raise TraceError("A time in the trace is NaN or infinite; leave such lines out.")
        if any(after[0] <= one[0] for one, after in pairwise(trace)):
            raise TraceError("The sending times do not rise; sort the trace by them.")
        if any(arrived < sent for sent, arrived in trace):
            raise TraceError("Something arrives before it was sent; both clocks must be one.")
        self._sent_ms = [sent for sent, _ in trace]
        self._delays_ms = [arrived - sent for sent, arrived in trace]

    @classmethod
    def from_lines(cls, lines: Iterable[str]) -> RecordedPath:
        """Read "sent_ms arrived_ms" lines; raises `TraceError` for any other."""
        trace: list[tuple[float, float]] = []
        for number, line in enumerate(lines, start=1):
            if not line.strip() or line.startswith("#"):
                continue
            try:
                sent, arrived = (float(word) for word in line.split())
            except ValueError as error:
                raise TraceError(f'Line {number} is not "sent_ms arrived_ms".') from error
            trace.append((sent, arrived))
        return cls(trace)

    def delay_ms(self, at_ms: float, chance: Random) -> float:
        length_ms = self._sent_ms[-1] - self._sent_ms[0]
        index = bisect_left(self._sent_ms, self._sent_ms[0] + at_ms % length_ms)
        return 2 * self._delays_ms[index]
