"""How fast the robot may run so that it stops within a distance when its operator is lost.

After the loss the robot runs on at speed v for a time t, until a watchdog fires, and then brakes at
b: it travels v·t + v²/2b. Only one of these watchdogs may still be working, so t is the longest of
their timeouts, plus one tick, since each checks its clock once a tick:

* the gate, when the newest command's time-to-live, counted from when it was sent, expires; a server
  that runs late checks later, by no more than the driver process tolerates;
* the driver process, when the server has been silent for too long;
* the robot itself, when the time-to-live of its newest frame expires.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from wax.control.rules import Rules


def unnoticed_s(ttl_s: float, rules: Rules) -> float:
    """Return how long the robot may run on after its operator is lost; `ttl_s` is a command's."""
    return max(ttl_s + rules.silence_s, rules.watchdog_s) + rules.period_s


def fastest_mps(ttl_s: float, rules: Rules) -> float:
    """Return the highest speed from which the robot stops within the configured distance."""
    t_s = unnoticed_s(ttl_s, rules)
    distance_m = rules.max_stop_distance_m
    # The solution of v·t + v²/2b = d, in the form without a subtraction that would lose precision.
    return 2 * distance_m / (t_s + math.sqrt(t_s * t_s + 2 * distance_m / rules.braking_mps2))
