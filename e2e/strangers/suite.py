"""The suite: strangers and networks do what they can, while somebody drives."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any, Final

from e2e.measure.suite import FIRMWARE, PAGE, SERVER, Case, Suite, measured
from e2e.strangers.attacks import ATTACKS
from e2e.strangers.hostile import AS_SHIPPED, hostile, public_robot
from e2e.strangers.join_flood import join_flood
from e2e.strangers.reconnect import reconnect
from e2e.strangers.slow_connections import slow_connections

if TYPE_CHECKING:
    from collections.abc import Mapping

    from e2e.stop.stage import Load

_ELSEWHERE: Final = ("offers-1", "offers-50", "slow")
"""Measured by `join_flood` and `slow_connections`, with what happens to others."""
_MIX_S: Final = 60
_SECONDS: Final = 20


def _hostile(key: str, *tables: Mapping[str, Any], load: Load = AS_SHIPPED) -> list[Case]:
    """Return all attacks against one configuration."""
    return [
        measured(
            f"{key}-{name}",
            _MIX_S if name == "mix" else _SECONDS,
            partial(hostile, name, tables=tables, load=load, key=key),
            f"seconds, {attack.what}",
            3,
        )
        for name, attack in ATTACKS.items()
        if name not in _ELSEWHERE
    ]


_PUBLIC, _PUBLIC_LOAD = public_robot()

SUITE: Final = Suite(
    name="public",
    about="Let strangers attack, and networks fail, while somebody drives.",
    measures=(*SERVER, *PAGE, *FIRMWARE),
    columns=("median", "p95", "p99", "max"),
    cases=(
        measured("join-flood-1", 60, lambda n: join_flood(n, 1), "seconds, from one address", 5),
        measured("join-flood-50", 60, lambda n: join_flood(n, 50), "seconds, from 50 addresses", 5),
        Case("reconnect", "times each way to lose the link", 50, reconnect, 2),
        measured("slow-connections", 3, slow_connections, "rounds of 500 from 50 addresses", 1),
        *_hostile("hostile"),
        *_hostile("public-robot", _PUBLIC, load=_PUBLIC_LOAD),
    ),
)
