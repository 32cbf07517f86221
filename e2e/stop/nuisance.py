"""Nuisance stops: how often the robot stops for no reason on a bad but sufficient link."""

from __future__ import annotations

import asyncio
import time
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Final

from tests.link.profile import parse

from e2e.load.crowd.modem import put_behind
from e2e.measure.row import judged
from e2e.stop.operator import RawOperator
from e2e.stop.stage import LIGHT, staged, together

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.measure.row import Row
    from e2e.stop.record import Seen

_WAY: Final = {
    "queue_bytes": 1_000_000,
    "delay_ms": 60.0,
    "jitter": {"distribution": "uniform", "ms": 30.0},
    "loss": {"in_good": 0.02},
    "reorder": True,
}
BAD: Final = parse({"about": "bad but sufficient", "down": _WAY, "up": _WAY}, "nuisance")
_SEED: Final = 2004
AT_ONCE: Final = 4
GOAL: Final = 1.0
"""Stops in ten minutes."""
_TEN_MINUTES_S: Final = 600.0


async def nuisance(n: int, *, at_once: int = AT_ONCE) -> list[Row]:
    """Drive for `n` seconds over bad links, several at once, and count the stops."""
    found = await together(*(_drive_badly(n / at_once) for _ in range(at_once)))
    stops, drove_s = (sum(values) for values in list(zip(*found, strict=True))[:2])
    return [
        judged(
            "nuisance",
            "stops for no reason in 10 min at 2 % loss and 60 ± 30 ms",
            "",
            {"max": stops * _TEN_MINUTES_S / drove_s},
            GOAL,
            n=n,
            column="max",
            load=LIGHT.beside(at_once),
            detail={
                "stops": stops,
                "one_way_ms": min(one_way_ms for _, _, one_way_ms, _ in found),
                "operator_late_ms": max(late_ms for *_, late_ms in found),
            },
        )
    ]


async def _drive_badly(for_s: float) -> tuple[int, float, float, float]:
    """Return the stops, for how many seconds the robot stood, and delay and lateness in ms."""
    bad = partial(put_behind, seed=_SEED, profile=BAD)
    async with staged(load=LIGHT) as stage, RawOperator(stage.server, on_socket=bad) as operator:
        await asyncio.sleep(2.0)  # the link's delay must be known at the turn's start
        await operator.join()
        await stage.drive(operator)
        since_s = time.monotonic()
        while time.monotonic() < since_s + for_s:
            await asyncio.sleep(0.5)
            stage.record.read()
            # A longer lapse needs a new press, which a person would give.
            if not stage.record.frames[-1].moves:
                await stage.drive(operator)
        until_s = time.monotonic()
        stage.record.read()
        one_way_ms = operator.clock.one_way_s * 1000
        stops = halts(stage.record.between(since_s, until_s))
        late_ms = operator.worst_late_s * 1000
    return stops, until_s - since_s, one_way_ms, late_ms


def halts(frames: Sequence[Seen]) -> int:
    return sum(before.moves and not after.moves for before, after in pairwise(frames))
