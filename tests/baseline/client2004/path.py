"""The delay of a media unit on its way."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from random import Random


class Path(Protocol):
    """A TCP stream: nothing is lost, everything arrives in order (the client sees to that)."""

    def delay_ms(self, at_ms: float, chance: Random) -> float:
        """Return the time from a request at `at_ms` until all of the answer has arrived."""
        ...


@dataclass(frozen=True, slots=True)
class SyntheticPath:
    """Delays between `least_ms` and `most_ms`, with an occasional one up to `spike_ms`."""

    least_ms: float
    most_ms: float
    spike_chance: float
    spike_ms: float

    def delay_ms(self, at_ms: float, chance: Random) -> float:
        if chance.random() < self.spike_chance:
            return chance.uniform(self.most_ms, self.spike_ms)
        return chance.uniform(self.least_ms, self.most_ms)
