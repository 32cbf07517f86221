"""The suite: strangers attack and networks fail while somebody drives; and what grows."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any, Final

from tests.fuzz.plan import TARGETS
from tests.fuzz.search import LONGEST_S

from e2e.measure.suite import FIRMWARE, PAGE, SERVER, Case, Suite, measured
from e2e.strangers.attacks import ALL, ATTACKS
from e2e.strangers.hostile import AS_SHIPPED, hostile, public_robot
from e2e.strangers.parsers import parser, parsers
from e2e.strangers.reconnect import FAULTS, reconnect
from e2e.strangers.soak import soaked

if TYPE_CHECKING:
    from collections.abc import Mapping

    from e2e.stop.stage import Load


def _hostile(key: str, table: Mapping[str, Any], load: Load) -> list[Case]:
    """Return a case of all attacks in turn on a configuration, and a long one of each."""
    every = [name for name in ATTACKS if name != ALL]
    return [
        measured(
            key,
            4,
            partial(hostile, names=every, key=key, table=table, load=load),
            f"seconds of each of {len(every)} attacks",
            2,
            minutes=5,
        ),
        *(
            measured(
                f"{key}-{name}",
                60,
                partial(hostile, names=[name], key=f"{key}-{name}", table=table, load=load),
                f"seconds, {attack.what}",
                3,
                minutes=2.5,
                long=True,
            )
            for name, attack in ATTACKS.items()
        ),
    ]


def _lost(n: int, minutes: float, *keys: str) -> Case:
    what = f"times, {', and '.join(FAULTS[key][0] for key in keys)}"
    return measured(f"reconnect-{keys[0]}", n, partial(reconnect, keys), what, 2, minutes=minutes)


SUITE: Final = Suite(
    name="strangers",
    about="What strangers do to whoever drives, how soon a lost link is back, and what grows.",
    measures=(*SERVER, *PAGE, *FIRMWARE, "tests/fuzz/**/*.py"),
    columns=("median", "p95", "p99", "max"),
    cases=(
        _lost(50, 17, "network", "absence"),
        _lost(12, 4.5, "outage"),
        *_hostile("hostile", {}, AS_SHIPPED),
        *_hostile("public-robot", *public_robot()),
        Case("parsers", "inputs for each parser", 4000, parsers, 200, 4),
        measured("soak", 300, soaked, "seconds of coming and going", 60, minutes=5.5),
        measured("soak-half-hour", 1800, soaked, "seconds of the same", 60, minutes=31, long=True),
        *(
            Case(
                f"fuzz-{name}", f"inputs, {target.what}", 1_000_000, partial(parser, target),
                20_000, LONGEST_S / 60, long=True,
            )
            for name, target in TARGETS.items()
        ),
    ),
    notes=(
        "Strangers, whoever drives and the server share the cores.",
        "What grows is the last sixth of five minutes less the one before the middle; ten observers"
        " come and go in the same rhythm in both.",
    ),
)  # fmt: skip
