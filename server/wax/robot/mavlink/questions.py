"""Requests to the rover: its parameters once, its telemetry until that arrives (pure)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from wax.robot.mavlink.codec import TELEMETRY
from wax.robot.mavlink.news import Battery

if TYPE_CHECKING:
    from wax.robot.mavlink.rover import Rover

ASK_EVERY_S: Final = 0.25
ASK_AGAIN_S: Final = 2.0
"""Requests are repeated at this interval: a restarted rover has forgotten them."""
BATTERY_HZ: Final = 1.0


class Questions:
    """Schedules the requests on one line."""

    def __init__(self, telemetry_hz: float) -> None:
        self._telemetry_hz = telemetry_hz
        self.begin()

    def begin(self) -> None:
        """Start over, with a rover about which nothing is known."""
        self._parameters_s = -math.inf
        self._telemetry_s = -math.inf

    def parameters(self, rover: Rover, now_s: float) -> tuple[str, ...]:
        """Return the parameters to request now."""
        if now_s < self._parameters_s:
            return ()
        names = rover.unasked(now_s)
        if names:
            self._parameters_s = now_s + ASK_EVERY_S
        return names

    def telemetry(self, rover: Rover, now_s: float) -> tuple[tuple[int, float], ...]:
        """Return the messages to request now, each with its rate."""
        if now_s < self._telemetry_s or not rover.answers(now_s):
            return ()
        since_s, self._telemetry_s = now_s - ASK_AGAIN_S, now_s + ASK_AGAIN_S
        return tuple(
            (number, BATTERY_HZ if kind is Battery else self._telemetry_hz)
            for number, kind in TELEMETRY.items()
            if not rover.told_since(kind, since_s)
        )

    def next_s(self, rover: Rover, now_s: float) -> float:
        """Return when the next request is due."""
        if not rover.answers(now_s):
            return math.inf
        asks = bool(rover.unasked(now_s))
        return min(self._parameters_s if asks else math.inf, self._telemetry_s)
