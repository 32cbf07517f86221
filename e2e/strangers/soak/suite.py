"""What grows in half an hour, what a thousand viewers leave, and the step of an hour's tape."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Final

from e2e.load.crowd import Crowd
from e2e.load.memory import BATCHES, FLAT_MIB, come_and_go
from e2e.load.servers import WAX, serving
from e2e.measure.row import counted, judged
from e2e.measure.suite import SERVER, Case, Suite
from e2e.strangers.soak.soak import rows, soak
from e2e.strangers.soak.tape import tape_in_step

if TYPE_CHECKING:
    from e2e.measure.row import Row


def _soaked(n: int) -> list[Row]:
    return rows(asyncio.run(soak(float(n))))


async def join_leave(n: int) -> list[Row]:
    """Let `n` viewers join, see, hear and leave."""
    batch = max(1, n // BATCHES)
    async with serving(WAX) as server:
        with await asyncio.to_thread(Crowd, server.offering) as crowd:
            leaked_mib, left = await come_and_go(server, crowd, batch)
    cycles = batch * BATCHES
    return [
        counted("join-leave: left", "threads, descriptors and tasks that they leave", left, cycles),
        judged(
            "join-leave: memory", "… memory", "MiB", {"max": leaked_mib}, FLAT_MIB,
            n=cycles, column="max",
        ),
    ]  # fmt: skip


SUITE: Final = Suite(
    name="soak",
    about="Serve an operator and observers who come and go for half an hour; see what grows. "
    "Record for an hour; see whether picture and sound stay in step.",
    measures=SERVER,
    columns=("max",),
    cases=(
        Case("half-hour", "seconds", 1800, _soaked, 60),
        Case("join-leave", "joins and leaves", 1000, lambda n: asyncio.run(join_leave(n)), 50),
        Case("tape", "seconds on the tape", 3600, lambda n: asyncio.run(tape_in_step(n)), 150),
    ),
    notes=(
        "The window at the end is the last sixth, compared with the one before the middle; ten"
        " observers come and go in the same rhythm in both.",
    ),
)
