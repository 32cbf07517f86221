"""The suite: strangers and networks do what they can, while somebody drives."""

from __future__ import annotations

from typing import Final

from e2e.measure.suite import FIRMWARE, PAGE, SERVER, Case, Suite, measured
from e2e.public.join_flood import join_flood
from e2e.public.reconnect import reconnect
from e2e.public.slow_connections import slow_connections

SUITE: Final = Suite(
    name="public",
    about="Let strangers flood and dawdle, and networks fail, while somebody drives.",
    measures=(*SERVER, *PAGE, *FIRMWARE),
    columns=("median", "p95", "p99", "max"),
    cases=(
        measured("join-flood-1", 60, lambda n: join_flood(n, 1), "seconds, from one address", 5),
        measured("join-flood-50", 60, lambda n: join_flood(n, 50), "seconds, from 50 addresses", 5),
        Case("reconnect", "times each way to lose the link", 50, reconnect, 2),
        measured("slow-connections", 3, slow_connections, "rounds of 500 from 50 addresses", 1),
    ),
)
