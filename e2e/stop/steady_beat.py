"""Jitter of the frames while observers watch and listen, and the encoders work for them."""

from __future__ import annotations

import asyncio
import time
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

from e2e.measure.row import judged, timed
from e2e.stop.operator import RawOperator
from e2e.stop.stage import staged

if TYPE_CHECKING:
    from collections.abc import Mapping

    from e2e.measure.row import Row

JITTER_MS: Final = 5.0
GAP_MS: Final = 40.0
PERIOD_MS: Final = 20.0


async def steady_beat(n: int, **settings: Any) -> list[Row]:
    """Read `n` gaps between the frames of a driving operator.

    The frames have the beat of the driver's process, which goes on through a stall of the loop's;
    how late the loop's own beats were it counts itself, those of the last minute. That is just the
    run where `n` is 3000; a shorter one counts the operator's arrival too.
    """
    async with staged(**settings) as stage, RawOperator(stage.server) as operator:
        await operator.join()
        await stage.drive(operator)
        await asyncio.sleep(1.0)
        since_s = time.monotonic()
        await asyncio.sleep(n * PERIOD_MS / 1000)
        until_s = time.monotonic()
        counters = (await stage.server.status())["counters"]
        stage.record.read()
        frames = stage.record.between(since_s, until_s)
    gaps_ms: list[float | None] = [(b.at_s - a.at_s) * 1000 for a, b in pairwise(frames)]
    # An extra frame between two periods does not delay the next one.
    jitter_ms: list[float | None] = [
        max(0.0, gap_ms - PERIOD_MS) for gap_ms in gaps_ms if gap_ms is not None
    ]
    return [
        timed(
            "steady-beat: jitter",
            "frames to the board: later than 20 ms after the one before",
            jitter_ms,
            JITTER_MS,
            judged="p99",
            stops=sum(not frame.moves for frame in frames),
            peer_late_ms=operator.worst_late_s * 1000,
        ),
        timed("steady-beat: gap", "… from one frame to the next", gaps_ms, GAP_MS),
        *own_beat(counters, n),
    ]


def own_beat(counters: Mapping[str, float], n: int) -> list[Row]:
    """Judge the loop's own count of its last `n` periods."""
    jitter_ms, latest_ms = counters["control.jitter_p99_ms"], counters["control.latest_ms"]
    late = {"p99": jitter_ms, "max": latest_ms}
    gap = {"max": latest_ms + PERIOD_MS}
    return [
        judged(
            "steady-beat: loop's jitter",
            "… how late the control loop's own beat was",
            "ms",
            late,
            JITTER_MS,
            n=n,
            column="p99",
        ),
        judged(
            "steady-beat: loop's gap",
            "… from one of the loop's beats to the next, at most",
            "ms",
            gap,
            GAP_MS,
            n=n,
            column="max",
        ),
    ]
