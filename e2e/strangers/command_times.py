"""How long a command takes from the operator's hand to the board, again and again."""

from __future__ import annotations

import asyncio
import random
import time
from contextlib import suppress
from typing import TYPE_CHECKING, Final

from e2e.measure.errors import MeasureError

if TYPE_CHECKING:
    from e2e.stop.operator import RawOperator
    from e2e.stop.stage import Stage

_SPEEDS: Final = (0.15, 0.25)
"""Shares of full speed: slower than any limit, and so close that the ramp takes two periods."""
_PAUSE_S: Final = (0.12, 0.18)
_LATEST_S: Final = 2.0


class CommandTimes:
    """Changes the speed at random phase while `run` runs; `between` gives the delays.

    Where the robot stands it presses again, as a person does; `stands_s` is when that was.
    """

    def __init__(self, stage: Stage, operator: RawOperator) -> None:
        self._stage = stage
        self._operator = operator
        self._changed_s: list[float] = []
        self.stands_s: list[float] = []

    async def run(self) -> None:
        """Change the speed until cancelled; the robot must be driving."""
        while True:
            for speed in _SPEEDS:
                self._stage.record.read()
                if not self._stage.record.is_moving(time.monotonic()):
                    self.stands_s.append(time.monotonic())
                    with suppress(MeasureError):
                        await self._stage.drive(self._operator)
                self._operator.steer(speed)
                self._changed_s.append(time.monotonic())
                self._operator.command()
                await asyncio.sleep(random.uniform(*_PAUSE_S))

    def between(self, since_s: float, until_s: float) -> list[float | None]:
        """Return the ms from each change to the first frame that shows it; None where none does."""
        self._stage.record.read()
        frames = self._stage.record.between(since_s - 1.0, until_s + _LATEST_S)
        found: list[float | None] = []
        number = 0
        for changed_s in self._changed_s:
            if not since_s <= changed_s <= until_s:
                continue
            while number < len(frames) and frames[number].at_s < changed_s:
                number += 1
            if number in (0, len(frames)):
                continue
            before = frames[number - 1].left_mmps
            shown_s = next((one.at_s for one in frames[number:] if one.left_mmps != before), None)
            found.append(None if shown_s is None else (shown_s - changed_s) * 1000)
        return found
