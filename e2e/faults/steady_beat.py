"""The beat of the frames while twenty watch and hear, and the encoder works for them."""

from __future__ import annotations

import asyncio
import time
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

from e2e.crowd import Crowd, Offering
from e2e.faults.finding import Figure, timed
from e2e.faults.operator import RawOperator
from e2e.faults.stage import staged

if TYPE_CHECKING:
    from collections.abc import Mapping

JITTER_MS: Final = 5.0
GAP_MS: Final = 40.0
VIEWERS: Final = 20
PERIOD_MS: Final = 20.0
_FULL: Final = {"video": {"source": "testcard"}, "audio": {"source": "testcard"}}


async def steady_beat(
    n: int, *, viewers: int = VIEWERS, **settings: Mapping[str, Any]
) -> list[Figure]:
    """Read `n` gaps between the frames of a driving operator; the shipped picture and sound.

    The frames have the beat of the driver's process, which goes on through a stall of the loop's;
    how late the loop's own beats were it counts itself, those of the last minute. That is just the
    run where `n` is 3000; a shorter one counts the crowd's arrival too.
    """
    async with staged(_FULL, settings) as stage, RawOperator(stage.server) as operator:
        await operator.join()
        offering = Offering(url=stage.server.url, wax=True)
        with await asyncio.to_thread(Crowd, offering) as crowd:
            await asyncio.to_thread(crowd.hold, viewers)
            await stage.drive(operator)
            await asyncio.sleep(1.0)
            since_s = time.monotonic()
            await asyncio.sleep(n * PERIOD_MS / 1000)
            until_s = time.monotonic()
            counters = (await stage.server.status())["counters"]
        stage.record.read()
        frames = stage.record.between(since_s, until_s)
    gaps_ms: list[float | None] = [(b.at_s - a.at_s) * 1000 for a, b in pairwise(frames)]
    # Where another frame goes out between two beats the next beat comes in time all the same.
    jitter_ms: list[float | None] = [
        max(0.0, gap_ms - PERIOD_MS) for gap_ms in gaps_ms if gap_ms is not None
    ]
    stops = sum(not frame.moves for frame in frames)
    return [
        timed(
            "steady-beat: jitter",
            "how much later than 20 ms after the one before",
            jitter_ms,
            JITTER_MS,
            judged="p99",
            viewers=viewers,
            stops=stops,
            peer_late_ms=operator.worst_late_s * 1000,
        ),
        timed("steady-beat: gap", "from one frame to the next", gaps_ms, GAP_MS),
        *own_beat(counters, n),
    ]


def own_beat(counters: Mapping[str, float], n: int) -> list[Figure]:
    """Judge what the loop counted of the last `n` of its beats."""
    jitter_ms, latest_ms = counters["control.jitter_p99_ms"], counters["control.latest_ms"]
    longest_ms = latest_ms + PERIOD_MS
    return [
        Figure(
            name="steady-beat: loop's jitter",
            what="how late the control loop's own beat was",
            unit="ms",
            n=n,
            p50=None,
            p99=jitter_ms,
            max=latest_ms,
            goal=JITTER_MS,
            judged="p99",
            met=jitter_ms <= JITTER_MS,
        ),
        Figure(
            name="steady-beat: loop's gap",
            what="from one of its beats to the next: the latest, and 20 ms",
            unit="ms",
            n=n,
            p50=None,
            p99=None,
            max=longest_ms,
            goal=GAP_MS,
            judged="max",
            met=longest_ms <= GAP_MS,
        ),
    ]
