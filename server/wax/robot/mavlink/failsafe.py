"""What an ArduPilot rover does when our link is lost, according to its parameters (pure).

- In GUIDED it stops GUID_TIMEOUT after the last set-point; firmware without that parameter does so
  after 3 s.
- With FS_GCS_ENABLE it acts FS_GCS_TIMEOUT plus FS_TIMEOUT after our last heartbeat; FS_ACTION says
  how, and not every action is a stop: 1, 3 and 4 drive it home.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Mapping

GROUND_STATIONS: Final = ("MAV_GCS_SYSID", "SYSID_MYGCS")
"""The parameter for the ground station that the rover obeys; newer firmware has the first name."""

QUESTIONS: Final = (
    ("FS_GCS_ENABLE",),
    ("FS_GCS_TIMEOUT",),
    ("FS_TIMEOUT",),
    ("FS_ACTION",),
    ("FS_THR_ENABLE",),
    ("GUID_TIMEOUT",),
    GROUND_STATIONS,
)
"""The parameters to request; of several names for one, one answer is enough."""

_STOPS: Final = (2, 6)
"""Hold; loiter or hold."""
_GOES_HOME: Final = (1, 3, 4)
_GUIDED_S: Final = 3.0
_GUIDED_LEAST_S: Final = 0.1
_ROUNDING_S: Final = 0.001
"""Parameters are single-precision."""


@dataclass(frozen=True, slots=True)
class Promise:
    """`stops_s` is how long after losing us the rover stops, None if it never does.

    `goes_home` says that it drives home by itself once it has lost us.
    """

    stops_s: float | None
    goes_home: bool


def promise(known: Mapping[str, float], *, is_guided: bool) -> Promise:
    """Derive the promise from the parameters that the rover has reported."""
    times_s = []
    if is_guided and known:
        times_s.append(max(_GUIDED_LEAST_S, known.get("GUID_TIMEOUT", _GUIDED_S)))
    action = round(known.get("FS_ACTION", 0.0))
    is_enabled = known.get("FS_GCS_ENABLE", 0.0) > 0.0
    acts_s = known.get("FS_GCS_TIMEOUT", math.inf) + known.get("FS_TIMEOUT", math.inf)
    if is_enabled and action in _STOPS and math.isfinite(acts_s):
        times_s.append(acts_s)
    return Promise(
        stops_s=min(times_s, default=None), goes_home=is_enabled and action in _GOES_HOME
    )


def told_s(known: Mapping[str, float], promised: Promise) -> float | None:
    """Return how long after losing us it says that it stops, 0 for never, None if unknown.

    A rover that stands for a while and then drives home does not count as stopping.
    """
    if promised.goes_home:
        return 0.0
    if promised.stops_s is not None:
        return promised.stops_s
    is_off = known.get("FS_GCS_ENABLE", math.inf) <= 0.0
    acts_otherwise = round(known.get("FS_ACTION", _STOPS[0])) not in _STOPS
    return 0.0 if is_off or acts_otherwise else None


def broken(promised: Promise, demanded_s: float) -> Sentence | None:
    """Return why the promise does not meet `demanded_s`; 0 demands nothing."""
    if demanded_s == 0.0:
        return None
    if promised.stops_s is None:
        return Sentence("mavlink.no_failsafe", {"seconds": demanded_s})
    if promised.stops_s > demanded_s + _ROUNDING_S:
        return Sentence(
            "mavlink.late_failsafe", {"seconds": promised.stops_s, "allowed": demanded_s}
        )
    return None


def warnings(promised: Promise) -> list[str]:
    """Return warnings for the host about a rover that may be driven all the same."""
    lines = []
    if promised.stops_s is None:
        lines.append(
            "the rover does not promise to stop when this computer dies: set its FS_GCS_ENABLE to 1"
            " and FS_ACTION to 2 (Hold)"
        )
    if promised.goes_home:
        lines.append(
            "the rover drives home by itself when it has lost this computer for long: set its"
            " FS_ACTION to 2 (Hold) unless you want that"
        )
    return lines


def obeys_another(known: Mapping[str, float], own_system: int) -> Sentence | None:
    """Return a sentence if the rover obeys another ground station's number."""
    for name in GROUND_STATIONS:
        theirs = known.get(name)
        if theirs is not None and round(theirs) != own_system:
            return Sentence(
                "mavlink.not_ours", {"theirs": f"{theirs:g}", "own": str(own_system), "name": name}
            )
        if theirs is not None:
            return None
    return None
