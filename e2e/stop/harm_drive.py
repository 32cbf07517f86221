"""The eight errors, applied to commands.

Right ones go ahead and wrong ones back, so a frame that goes back is a wrong execution; so is one
that moves though commands have been lost for longer than one lasts.
"""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING, Any, Final

from e2e.harness.wait import eventually
from e2e.stop.harm import NO_COMMANDS

if TYPE_CHECKING:
    from collections.abc import Iterator

    from e2e.stop.harm import Channel
    from e2e.stop.record import Seen

_AHEAD: Final = 1.0
_BACK: Final = -1.0
_SOON_S: Final = 0.03
_LASTS_S: Final = 0.2
"""A command is valid for 150 ms; the stop follows soon after, as with every other fault."""


class DriveHarm:
    """Injects errors while the robot drives ahead; `pressed_anew` counts earlier standstills."""

    def __init__(self, channel: Channel) -> None:
        self.pressed_anew = 0
        self._channel = channel
        self._operator = channel.operator
        self._record = channel.stage.record
        self._judged = 0

    async def drive(self, error: str) -> int:
        """Send what must not be obeyed; count what is, except for what `went_back` counts."""
        operator = self._operator
        await self._go_ahead()
        match error:
            case "corruption":
                operator.drive.send(self._channel.damaged(self._row()))
            case "repetition":
                await self._repeat()
            case "wrong order":
                await self._overtake()
            case "loss":
                return await self._lose()
            case "delay":
                sent_ms = operator.server_ms() - self._channel.some_ms(300, 5000)
                operator.drive.send(self._row(sent_server_ms=sent_ms))
            case "insertion":
                for said in self._inserted():
                    operator.drive.send(said)
            case "masquerade":
                self._channel.stranger.drive.send(self._row())
            case _:
                self._misaddress()
        return 0

    def went_back(self) -> int:
        """Count the frames that drove back since the last count."""
        frames = self._frames()
        found = sum(_goes_back(frame) for frame in frames[self._judged :])
        self._judged = len(frames)
        return found

    async def _go_ahead(self) -> None:
        if not await self._channel.stage.moves(_SOON_S):
            await self._channel.stage.drive(self._operator)
            self.pressed_anew += 1

    async def _repeat(self) -> None:
        """Repeat a command that was rightly obeyed, after the operator has changed direction."""
        operator = self._operator

        async def press_back() -> None:
            operator.let_go()
            await asyncio.sleep(0.06)
            operator.steer(_BACK)

        await self._channel.stage.moving(press_back)
        row = operator.row(operator.next_seq())
        operator.drive.send(row)
        await asyncio.sleep(0.02)
        operator.steer(_AHEAD)
        operator.command()
        await eventually(self._is_over, "the robot goes back no more", every_s=0.005)
        self._judged = len(self._record.frames)
        operator.drive.send(row)
        await asyncio.sleep(0.02)
        operator.drive.send(row)

    async def _is_over(self) -> bool:
        return not _goes_back(self._frames()[-1])

    async def _overtake(self) -> None:
        """Let a newer command overtake one."""
        row = self._row()
        self._operator.command()
        await asyncio.sleep(self._channel.random.uniform(0.03, 0.1))
        self._operator.drive.send(row)

    async def _lose(self) -> int:
        """Lose commands for a while; one is only delayed, and arrives after newer ones."""
        operator = self._operator
        operator.is_silent = True
        last_s = operator.sent_before[-1].at_s
        row = self._row()
        await asyncio.sleep(self._channel.some_ms(30, 600) / 1000)
        again_s = time.monotonic()
        operator.is_silent = False
        operator.command()
        operator.drive.send(row)
        await asyncio.sleep(_SOON_S)
        self._record.read()
        return sum(frame.moves for frame in self._record.between(last_s + _LASTS_S, again_s))

    def _misaddress(self) -> None:
        """Send a command on the wrong channel, or for another turn."""
        operator, random = self._operator, self._channel.random
        if random.random() < 0.5:
            operator.state.send(self._row())
        else:
            turn = operator.turn + random.choice((-1, 1, 2, 3))
            operator.drive.send(self._row(turn=turn))

    def _inserted(self) -> Iterator[str | bytes]:
        """Send noise, a command without dead-man, one from a fast clock, and an invalid one."""
        random = self._channel.random
        yield random.randbytes(60)
        yield self._row(held=False)
        yield self._row(sent_server_ms=self._operator.server_ms() + random.uniform(1000, 5000))
        yield self._row(**random.choice(NO_COMMANDS))

    def _row(self, **other: Any) -> str:
        """Write the next command, which drives back and would be correct except for `other`."""
        said = {"linear": _BACK, "held": True} | other
        return self._operator.row(self._operator.next_seq(), **said)

    def _frames(self) -> list[Seen]:
        self._record.read()
        return self._record.frames


def _goes_back(frame: Seen) -> bool:
    return frame.left_mmps < 0 or frame.right_mmps < 0
