"""From the traffic on the serial line to the robot's stopping times (pure)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence


@dataclass(frozen=True, slots=True)
class Event:
    """One frame on the serial line, from the server (`said`) or from the robot (`told`).

    `moves` is whether it requests or reports motion; `speed_mps` is that of the faster wheel, None
    if the dialect has no number for it.
    """

    at_s: float
    who: Literal["said", "told"]
    moves: bool
    speed_mps: float | None = None


@dataclass(frozen=True, slots=True)
class Sample:
    """The results of one fault, in ms after it; None for what did not happen.

    `frame_ms` is the stop frame after which no motion was requested, `standing_ms` the robot's
    report after which it reported no motion. `speed_mps` was requested before the fault.
    """

    frame_ms: float | None
    standing_ms: float | None
    speed_mps: float | None

    @property
    def braking_ms(self) -> float | None:
        """The robot's own part: from the stop frame to its report; None if either is missing."""
        if self.frame_ms is None or self.standing_ms is None:
            return None
        return max(self.standing_ms - self.frame_ms, 0.0)


def measure(events: Sequence[Event], fault_s: float) -> Sample:
    """Return the results of a fault at `fault_s` from events in order of time."""
    after = [event for event in events if event.at_s >= fault_s]
    speeds = (e.speed_mps for e in reversed(events) if e.at_s < fault_s and e.who == "said")
    return Sample(
        frame_ms=_since(fault_s, _first_of_rest(e for e in after if e.who == "said")),
        standing_ms=_since(fault_s, _first_of_rest(e for e in after if e.who == "told")),
        speed_mps=next(speeds, None),
    )


def _first_of_rest(events: Iterable[Event]) -> Event | None:
    """Return the first event of the standstill that lasts to the end, None if there is none."""
    first: Event | None = None
    for event in events:
        if event.moves:
            first = None
        elif first is None:
            first = event
    return first


def _since(fault_s: float, event: Event | None) -> float | None:
    return None if event is None else (event.at_s - fault_s) * 1000.0
