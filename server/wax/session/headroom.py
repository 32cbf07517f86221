"""Whether the event loop has time for one viewer more.

By what it does for those who are here, not by how late it is: whoever makes it late, a stranger,
a viewer who asks for much or another program, would keep everybody out.
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
"""Of a core. What is charged to strangers and viewers (`wax.edge`) may be the rest of it."""
CORES_SHARE: Final = 0.9
"""Of all cores that this process may use, for a machine with few of them."""
_LOOK_S: Final = 1.0
_LATELY: Final = 10
"""So many looks: a rush of newcomers, whose answers take time, is over by then."""


@dataclass(frozen=True, slots=True)
class Used:
    """Seconds of processor time since the start: they only rise.

    `charged_s` is the part of `loop_s` that was charged to somebody.
    """

    loop_s: float
    process_s: float
    charged_s: float


class Headroom:
    """`cores` are those that this process may use, `charged_s` what was charged since the start."""

    def __init__(self, cores: float, clock: Clock, charged_s: Callable[[], float]) -> None:
        self._cores = cores
        self._clock = clock
        self._charged_s = charged_s
        self._looks: deque[tuple[float, Used]] = deque(maxlen=_LATELY + 1)

    async def run(self) -> None:
        """Look until cancelled, in the event loop that is looked at."""
        while True:
            self.look(Used(time.thread_time(), time.process_time(), self._charged_s()))
            await asyncio.sleep(_LOOK_S)

    def look(self, used: Used) -> None:
        self._looks.append((self._clock.now_s(), used))

    def has_time(self, served: int) -> bool:
        """Whether one more fits beside so many, of whom each takes as much; so before two looks."""
        if len(self._looks) < 2:
            return True
        (since_s, before), *_, (until_s, now) = self._looks
        lasted_s = until_s - since_s
        charged_s = now.charged_s - before.charged_s
        loop = (now.loop_s - before.loop_s - charged_s) / lasted_s
        process = (now.process_s - before.process_s - charged_s) / lasted_s
        one_more = loop / max(served, 1)
        return loop + one_more <= LOOP_SHARE and process + one_more <= CORES_SHARE * self._cores
