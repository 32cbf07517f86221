"""The limits that all connections share."""

from __future__ import annotations

import asyncio
from functools import partial

from tests.turned_clock import TurnedClock

from wax.config.server import ServerSettings
from wax.edge.turnstile import Turnstile
from wax.web.http_limits import HttpLimits


async def test_connections_that_time_out_together_end_a_few_in_a_pass() -> None:
    clock = TurnedClock()
    limits = HttpLimits(ServerSettings(), clock, Turnstile(clock))
    ended: list[int] = []

    async def after_passes(number: int) -> list[int]:
        found: list[int] = []
        for _ in range(number):
            await asyncio.sleep(0)
            found.append(len(ended))
        return found

    for number in range(10):
        limits.end_soon(partial(ended.append, number))
    assert await after_passes(4) == [4, 8, 10, 10]
    limits.end_soon(partial(ended.append, 10))
    assert await after_passes(1) == [11]
    assert ended == list(range(11))
