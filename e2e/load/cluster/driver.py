"""Drives in a process of its own, so that nothing that measures makes it late.

``python -m e2e.load.cluster.driver URL LOG`` joins the queue and turns the robot until its standard
input ends; where the robot stops, it lets go and presses again, as a person does. It writes to LOG
when each picture began to arrive, in seconds of `time.monotonic`, the same in every process here,
and why the robot stopped. A line on standard input is its name from then on.
"""

from __future__ import annotations

import asyncio
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from wax.client.operator import Operator
from wax.sentence import read

if TYPE_CHECKING:
    from collections.abc import Sequence
    from typing import TextIO

_LOOK_S: Final = 0.005
_PRESS_S: Final = 0.1
_AGAIN_S: Final = 0.4
_SWEEP: Final = 100
_SLOWEST: Final = 0.3
_STEP: Final = 0.005


def sweep(seq: int) -> float:
    """Return the share of full speed of this command: up and down, never twice the same."""
    at = seq % (2 * _SWEEP)
    return _SLOWEST + _STEP * min(at, 2 * _SWEEP - at)


class Sweeping(Operator):
    """Turns on the spot, by another speed with every command."""

    def row(self, seq: int, **other: Any) -> str:
        if self.held:
            self.angular = sweep(seq)
        return super().row(seq, **other)


async def drive(url: str, log: TextIO) -> None:
    """Drive until standard input ends; raises what `Operator.join` does."""
    moves: list[bool] = []

    def heard(message: dict[str, Any]) -> None:
        if message["type"] != "drive_status":
            return
        if moves[-1:] == [True] and not message["moving"]:
            reason = message["reason"]
            log.write(f"stopped: {None if reason is None else read(reason)}\n")
        moves.append(message["moving"])

    async with Sweeping(url, sees=True, on_message=heard) as operator:
        await operator.join()
        works = (_look(operator, log), _press(operator, moves))
        tasks = [asyncio.create_task(work) for work in works]
        while line := await asyncio.to_thread(sys.stdin.readline):
            operator.say(type="name", name=line.strip())
        for task in tasks:
            task.cancel()


async def _press(operator: Operator, moves: Sequence[bool]) -> None:
    """Press whenever the robot stands."""
    while True:
        if moves[-1:] != [True]:
            operator.let_go()
            await asyncio.sleep(_PRESS_S)
            operator.steer(0.0, _SLOWEST)  # on the spot, where there is no wall
        await asyncio.sleep(_AGAIN_S)


async def _look(operator: Operator, log: TextIO) -> None:
    """Note each picture once."""
    noted_s = 0.0
    while True:
        newest = operator.media.newest("video")
        if newest is not None and newest.at_s > noted_s:
            noted_s = newest.at_s
            log.write(f"{noted_s:.4f}\n")
            log.flush()
        await asyncio.sleep(_LOOK_S)


if __name__ == "__main__":
    with Path(sys.argv[2]).open("w", encoding="utf-8") as file:
        asyncio.run(drive(sys.argv[1], file))
