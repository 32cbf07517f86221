"""Where what a sender has decided to send waits for its track: a moment, never longer."""

from __future__ import annotations

import asyncio
from collections import deque
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

    from wax.media.encoded import EncodedPicture, EncodedSound

    Encoded = EncodedPicture | EncodedSound


class UnitLane:
    """Hands out one media unit's packets without a pause, then waits for the next unit.

    It needs no bound: nothing is put into it before what went before was acknowledged or lost.
    """

    def __init__(self) -> None:
        self._queue: deque[Encoded] = deque()
        self._ready = asyncio.Event()

    def put(self, packets: Iterable[Encoded]) -> None:
        self._queue.extend(packets)
        self._ready.set()

    async def get(self) -> Encoded:
        """Wait for the next packet to send."""
        while not self._queue:
            self._ready.clear()
            await self._ready.wait()
        return self._queue.popleft()
