"""The operator, whom nothing of the cluster concerns: what a fault of it does to them."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Final

from e2e.load.cluster.page import now_ms
from e2e.measure.row import Row, counted, timed

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from e2e.load.cluster.driving import Driving

GAP_MS: Final = 100.0
_AFTER_S: Final = 0.5
"""What stands at the end has moved again by then, or the gap has no end."""


class Bystander:
    """Sums up what comes to an operator, and from them to the board, around each fault."""

    def __init__(self, operator: Driving) -> None:
        self._operator = operator
        self._pictures_ms: list[float] = []
        self._commands_ms: list[float] = []
        self._stops = 0
        self._reasons: list[str] = []

    @asynccontextmanager
    async def beside(self) -> AsyncIterator[None]:
        """Take what there is during the block."""
        from_ms = now_ms()
        yield
        to_ms = now_ms()
        await asyncio.sleep(_AFTER_S)
        self._pictures_ms.append(self._operator.picture_gap_ms(from_ms, to_ms))
        self._commands_ms.append(self._operator.command_gap_ms(from_ms, to_ms))
        self._stops += self._operator.stops(from_ms, to_ms)
        self._reasons = self._operator.reasons()

    def rows(self, key: str) -> list[Row]:
        """Judge the longest gap around each fault, and count the stops."""
        return [
            timed(
                f"{key}: operator's picture",
                "… meanwhile the operator's longest time without a picture",
                self._pictures_ms,
                GAP_MS,
            ),
            timed(
                f"{key}: operator's commands",
                "… and the board's without a new command",
                self._commands_ms,
                GAP_MS,
            ),
            counted(
                f"{key}: stops",
                "… stops",
                self._stops,
                len(self._commands_ms),
                reasons=self._reasons,
            ),
        ]
