"""Somebody presses Stop while a viewer floods the command channel: others, or the flooder."""

from __future__ import annotations

import asyncio
import time
from itertools import cycle
from typing import TYPE_CHECKING, Any, Final

from e2e.harness.wait import eventually
from e2e.measure.row import timed
from e2e.stop.flooder import flooding
from e2e.stop.operator import RawOperator
from e2e.stop.stage import STOPS_AT_EACH_TRIAL, staged
from e2e.stop.trials import repeat

if TYPE_CHECKING:
    from e2e.harness.server import Server
    from e2e.measure.row import Row
    from e2e.stop.flooder import Flood
    from e2e.stop.record import Stopping
    from e2e.stop.stage import Stage

GOAL_MS: Final = 100.0
RATE_HZ: Final = 10_000.0
_OWN: Final = "flooder, channel"
WAYS: Final = (
    "operator, channel",
    "operator, HTTP",
    "observer, channel",
    "observer, HTTP",
    _OWN,
)
_LOOK_S: Final = 0.15


async def stop_in_flood(n: int, *, rate_hz: float = RATE_HZ, **settings: Any) -> list[Row]:
    """Time from the press to the first stopping frame, for each way of pressing in turn.

    The flooder's own is a row of its own: it shares a connection with their flood, and what is
    lost there waits to be sent again.
    """
    async with (
        staged(STOPS_AT_EACH_TRIAL, **settings) as stage,
        RawOperator(stage.server) as operator,
        RawOperator(stage.server) as observer,
    ):
        await operator.join()
        return await _flooded(n, rate_hz, stage, operator, observer)


async def _flooded(
    n: int, rate_hz: float, stage: Stage, operator: RawOperator, observer: RawOperator
) -> list[Row]:
    async with flooding(stage.server.url, rate_hz) as flood:
        before = await _refused(stage.server)
        begun_s = time.monotonic()
        ways = cycle(WAYS)
        by_way: dict[str, list[float | None]] = {way: [] for way in WAYS}

        async def trial() -> Stopping | None:
            await stage.drive(operator)
            way = next(ways)
            who = operator if way.startswith("operator") else observer
            since_s = await _press(way, who, flood)

            async def told() -> bool:
                return operator.stopped is not None

            await eventually(told, "the operator is told of the stop", every_s=0.01)
            await asyncio.sleep(_LOOK_S)
            until_s = time.monotonic()
            stop = operator.stopped
            assert stop is not None
            operator.let_go()
            await asyncio.sleep(0.04)
            operator.release(stop)

            async def released() -> bool:
                return operator.stopped is None

            await eventually(released, "the stop is released", every_s=0.01)
            stage.record.read()
            if not stage.record.moved_at(since_s):
                return None
            found = stage.record.stopping(since_s, until_s)
            by_way[way].append(found.told_ms)
            return found

        trials = await repeat("stop-in-flood", n, trial)
        took_s = time.monotonic() - begun_s
        heard_hz = (await _refused(stage.server) - before) / took_s
        sent = await flood.end()
    own_ms = by_way.pop(_OWN)
    return [
        timed(
            "stop-in-flood",
            f"Stop pressed in a flood of {sent['sent_hz']:.0f} messages a second → stop frame",
            [ms for values in by_way.values() for ms in values],
            GOAL_MS,
            judged="p99",
            wrong=sum(one.moved_again for one in trials.results),
            void=trials.void,
            flood_wanted_hz=rate_hz,
            flood_sent_hz=sent["sent_hz"],
            flood_heard_hz=heard_hz,
            by_way_max_ms={
                way: max((ms for ms in values if ms is not None), default=None)
                for way, values in by_way.items()
            },
        ),
        timed(
            "stop-in-flood: own",
            "… by the flooder, over the very connection that they flood",
            own_ms,
            GOAL_MS,
            judged="p99",
        ),
    ]


async def _press(way: str, who: RawOperator, flood: Flood) -> float:
    """Press Stop in one way; return when, in s of `time.monotonic`."""
    since_s = time.monotonic()
    if way == _OWN:
        return await flood.press_stop()
    if way.endswith("HTTP"):
        await who.press_stop()
    else:
        who.say(type="stop")
    return since_s


async def _refused(server: Server) -> float:
    counters = (await server.status())["counters"]
    return float(counters.get("messages over the rate", 0))
