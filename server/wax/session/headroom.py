"""Whether the event loop has time for one more viewer, of whom `entry` asks: a newcomer, no host.

The measure is its processor time for those who are here, not how late it is: a stranger, a
demanding viewer or another program could make it late, and so keep everybody out.
"""

from __future__ import annotations

import asyncio
import time
from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.clock import Clock

LOOP_SHARE: Final = 0.6
"""Of one core; work charged to strangers and viewers (`wax.edge`) may use the rest."""
CORES_SHARE: Final = 0.9
"""Of all cores that this process may use; matters on a machine with few."""
FIRST_DOZEN: Final = 12
"""This many are let in however busy the machine is: it may be busy with something else."""
_SAMPLE_S: Final = 1.0
_LATELY: Final = 10
"""Samples kept: a rush of newcomers, whose answers take time, is over by then."""


@dataclass(frozen=True, slots=True)
class Used:
    """Processor time since the start, in seconds; it only rises.

    `charged_s` is the part of `loop_s` that was charged to somebody.
    """

    loop_s: float
    process_s: float
    charged_s: float


class Headroom:
    """`cores` is how many this process may use; `charged_s` returns what was charged so far."""

    def __init__(self, cores: float, clock: Clock, charged_s: Callable[[], float]) -> None:
        self._cores = cores
        self._clock = clock
        self._charged_s = charged_s
        self._samples: deque[tuple[float, Used]] = deque(maxlen=_LATELY + 1)

    async def run(self) -> None:
        """Sample until cancelled; run it in the event loop to be measured."""
        while True:
            self.sample(Used(time.thread_time(), time.process_time(), self._charged_s()))
            await asyncio.sleep(_SAMPLE_S)

    def sample(self, used: Used) -> None:
        self._samples.append((self._clock.now_s(), used))

    def has_time(self, served: int) -> bool:
        """Whether one more fits, if they cost the average of `served`; True before two samples."""
        if served < FIRST_DOZEN or len(self._samples) < 2:
            return True
        (since_s, before), *_, (until_s, now) = self._samples
        lasted_s = until_s - since_s
        charged_s = now.charged_s - before.charged_s
        loop = (now.loop_s - before.loop_s - charged_s) / lasted_s
        process = (now.process_s - before.process_s - charged_s) / lasted_s
        one_more = loop / max(served, 1)
        return loop + one_more <= LOOP_SHARE and process + one_more <= CORES_SHARE * self._cores
