"""The suite: breaks each link from finger to wheel while the robot drives, and times the stop."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Final

from e2e.measure.suite import FIRMWARE, PAGE, SERVER, Suite, measured
from e2e.stop.fault import measure
from e2e.stop.faults import FAULTS
from e2e.stop.hand_over import hand_over
from e2e.stop.nuisance import nuisance

if TYPE_CHECKING:
    from e2e.measure.suite import Case
    from e2e.stop.fault import Fault


def _case(fault: Fault) -> Case:
    names = ", ".join(kind.key for kind in fault.kinds)
    title = f"{fault.what}; each of {names}" if len(fault.kinds) > 1 else fault.what
    run = partial(measure, fault)
    return measured(fault.key, fault.n, run, title, 2, minutes=fault.minutes)


SUITE: Final = Suite(
    name="stop",
    about="Break each link from finger to wheel while the robot drives; time the stop.",
    measures=(*SERVER, *PAGE, *FIRMWARE),
    columns=("median", "p99", "max"),
    cases=(
        *(_case(fault) for fault in FAULTS),
        measured("hand-over", 150, hand_over, "turns: nothing old may move", 6, minutes=1.2),
        measured("nuisance", 600, nuisance, "seconds over bad links, stops counted", 40, minutes=3),
    ),
    notes=(
        "Each driver's robot is a program that knows nothing of WAX, in a process of its own; of"
        " rosbridge, our own server by its protocol's text, and mock pins in the driver's process.",
    ),
)
