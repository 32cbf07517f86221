"""How fast the robot may run so that it stands in time when its operator is lost.

From the moment of the loss it runs on at speed v for a time t, until somebody notices, and then
brakes at b: it travels v·t + v²/2b. Each of these notices alone, and any but one may be what has
failed, so t is the longest of them, and a beat, since each looks at its clock once a beat:

* the gate, when the newest command's time to live is over, which began when it was sent; a server
  that is late looks later, by no more than what the driver's process puts up with;
* the driver's process, when the server has said nothing for its time of silence;
* the robot itself, when the time to live of its newest frame is over.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from wax.control.rules import Rules


def unnoticed_s(ttl_s: float, rules: Rules) -> float:
    """Say for how long the robot may run on after its operator was lost; `ttl_s` is a command's."""
    return max(ttl_s + rules.silence_s, rules.watchdog_s) + rules.beat_s


def fastest_mps(ttl_s: float, rules: Rules) -> float:
    """Return the largest speed at which the robot stands within the configured distance."""
    t_s = unnoticed_s(ttl_s, rules)
    distance_m = rules.max_stop_distance_m
    # The solution of v·t + v²/2b = d in the form that subtracts nothing, so it never cancels out.
    return 2 * distance_m / (t_s + math.sqrt(t_s * t_s + 2 * distance_m / rules.braking_mps2))
