"""The public suite, short: strangers who flood and dawdle keep nobody out."""

from __future__ import annotations

import sys
from collections import Counter
from typing import TYPE_CHECKING

import pytest

from e2e.measure.table import to_table
from e2e.stop.stage import LIGHT
from e2e.strangers.join_flood import join_flood
from e2e.strangers.slow_connections import slow_connections

if TYPE_CHECKING:
    from e2e.measure.row import Row

pytestmark = [
    pytest.mark.timeout(120),
    pytest.mark.skipif(sys.platform != "linux", reason="only Linux has all of 127.0.0.0/8"),
]

SECONDS = 3


def _assert_met(rows: list[Row], *suffixes: str) -> None:
    judged = [row for row in rows if row.key.endswith(suffixes)]
    assert len(judged) == len(suffixes)
    assert all(row.met for row in judged), to_table(rows)


@pytest.mark.full
async def test_a_flood_of_offers_keeps_nobody_out() -> None:
    """The host gets in meanwhile and a guest afterwards, and the robot drives on."""
    rows = await join_flood(SECONDS, 50, load=LIGHT)
    _assert_met(rows, "host", "guest", "memory", "memory after")
    did = Counter(rows[0].detail["account"]["did"])
    assert did["answered 429"] + did["answered 503"] > 0.8 * did["offers"], did
    assert did["answered 200"] >= 8, "these were offers that can be answered"
    assert rows[0].n > 0


@pytest.mark.full
async def test_slow_connections_are_closed_in_time() -> None:
    """Each after ten seconds at most, others are answered meanwhile, and nothing is left."""
    rows = await slow_connections(1)
    _assert_met(rows, "slow-connections", "others", "left")
