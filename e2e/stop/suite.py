"""The suite: breaks each link from finger to wheel while the robot drives, and times the stop."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any, Final

from e2e.measure.suite import FIRMWARE, PAGE, SERVER, Case, Suite
from e2e.stop.fault import measure
from e2e.stop.faults import FAULTS
from e2e.stop.hand_over import hand_over
from e2e.stop.nuisance import nuisance
from e2e.stop.stage import DEFAULT

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine

    from e2e.measure.row import Row
    from e2e.stop.fault import Fault

    Measure = Callable[[int], Coroutine[Any, Any, list[Row]]]


def case(
    key: str,
    n: int,
    measure: Measure,
    title: str,
    quick: int = 2,
    *,
    minutes: float,
) -> Case:
    """Make a case of a measurement on a stage; a row says its load, where it is another."""

    def run(n: int) -> list[Row]:
        # A loop for each, so that leftovers of one do not disturb the next.
        rows = asyncio.run(measure(n))
        return [row if row.load else row.model_copy(update={"load": str(DEFAULT)}) for row in rows]

    return Case(key, title, n, run, quick, minutes)


def _case(fault: Fault) -> Case:
    async def run(n: int) -> list[Row]:
        return await measure(fault, n)

    names = ", ".join(kind.key for kind in fault.kinds)
    title = f"{fault.what}; each of {names}" if len(fault.kinds) > 1 else fault.what
    return case(fault.key, fault.n, run, title, minutes=fault.minutes)


SUITE: Final = Suite(
    name="stop",
    about="Break each link from finger to wheel while the robot drives; time the stop.",
    measures=(*SERVER, *PAGE, *FIRMWARE),
    columns=("median", "p99", "max"),
    cases=(
        *(_case(fault) for fault in FAULTS),
        case("hand-over", 150, hand_over, "turns in which nothing old may move", 6, minutes=1.2),
        case("nuisance", 600, nuisance, "seconds over bad links, stops counted", 40, minutes=3),
    ),
    notes=(
        "Each driver's robot is a program that knows nothing of WAX, in a process of its own; of"
        " rosbridge, our own server by its protocol's text, and mock pins in the driver's process.",
    ),
)
