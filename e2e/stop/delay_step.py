"""The delay suddenly grows fiftyfold: late commands must move nothing."""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING, Any, Final

from e2e.measure.row import counted
from e2e.stop.operator import RawOperator
from e2e.stop.relay import Relay, Weather
from e2e.stop.stage import staged
from e2e.stop.trials import repeat, told

if TYPE_CHECKING:
    from e2e.measure.row import Row
    from e2e.stop.record import Stopping

GOAL_MS: Final = 200.0
SHORT: Final = Weather(delay_ms=20)
LONG: Final = Weather(delay_ms=1000)
_LATE_S: Final = 1.5
"""How long late commands keep arriving after the step: half a second of them."""


async def delay_step(n: int, **settings: Any) -> list[Row]:
    """Time from the arrival of the last fresh command; late ones keep arriving for 0.5 s."""
    relay = Relay(SHORT)
    async with staged(**settings) as stage, RawOperator(stage.server, relay=relay) as operator:
        await operator.join()
        # Heartbeats must measure the link's delay before a turn can rely on it.
        await asyncio.sleep(1.0)
        await operator.leave()
        await operator.join()

        async def trial() -> Stopping | None:
            relay.up.clear()
            await stage.drive(operator)
            relay.weather = LONG
            step_s = time.monotonic()
            last_s = relay.last_command_s
            await asyncio.sleep(_LATE_S)
            # Commands still in flight are neutral; the robot must not move because of them either.
            until_s = time.monotonic()
            operator.let_go()
            stage.record.read()
            found = stage.record.stopping(last_s, until_s)
            moved = stage.record.moved_at(step_s)
            relay.weather = SHORT
            await asyncio.sleep(1.1)
            return found if moved else None

        trials = await repeat("delay-step", n, trial)
    late = sum(one.moved_again for one in trials.results)
    what = "delay steps from 20 to 1000 ms one way: last fresh command → stop frame"
    return [
        told("delay-step", what, trials, GOAL_MS),
        counted("delay-step: late", "… late commands executed", late, len(trials.results)),
    ]
