"""The suite: strangers and networks do what they can, while somebody drives."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any, Final

from e2e.measure.suite import FIRMWARE, PAGE, SERVER, Case, Suite
from e2e.public.join_flood import join_flood
from e2e.public.reconnect import reconnect
from e2e.public.slow_connections import slow_connections

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine

    from e2e.measure.row import Row

    Measure = Callable[[int], Coroutine[Any, Any, list[Row]]]


def _case(key: str, n: int, measure: Measure, title: str, quick: int) -> Case:
    return Case(key, title, n, lambda n: asyncio.run(measure(n)), quick)


SUITE: Final = Suite(
    name="public",
    about="Let strangers flood and dawdle, and networks fail, while somebody drives.",
    measures=(*SERVER, *PAGE, *FIRMWARE),
    columns=("median", "p95", "p99", "max"),
    cases=(
        _case("join-flood-1", 60, lambda n: join_flood(n, 1), "seconds, from one address", 5),
        _case("join-flood-50", 60, lambda n: join_flood(n, 50), "seconds, from 50 addresses", 5),
        Case("reconnect", "times each way to lose the link", 50, reconnect, 2),
        _case("slow-connections", 3, slow_connections, "rounds of 500 from 50 addresses", 1),
    ),
)
