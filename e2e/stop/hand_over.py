"""Hands over from one operator to the next, repeatedly: nothing of the old turn may follow.

Frames on the wire count, whether the board accepts them or not, because it also refuses an old turn
itself. Each of the two operators drives in a direction of its own, so that a frame's number shows
the turn, and its wheels show the operator.
"""

from __future__ import annotations

import asyncio
import time
from contextlib import AsyncExitStack
from dataclasses import dataclass
from random import Random
from typing import TYPE_CHECKING, Any, Final, Literal, get_args

from e2e.measure.errors import MeasureError
from e2e.measure.row import counted
from e2e.stop.operator import Browser, RawOperator
from e2e.stop.relay import Relay
from e2e.stop.stage import staged

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from e2e.measure.row import Row
    from e2e.stop.record import Seen
    from e2e.stop.stage import Stage

_TURN_S: Final = 1.0
_LOST_S: Final = 1.0
"""The server considers an operator lost after this long without a message."""
_ASKS: Final = 15
_ASK_EVERY_S: Final = 1.5

Ending = Literal["leave", "expire", "vanish", "crash", "reconnect"]
ENDINGS: Final[tuple[Ending, ...]] = get_args(Ending)
_WEIGHTS: Final = (70, 15, 5, 5, 5)


@dataclass(frozen=True, slots=True)
class Switches:
    """All switches from one turn to the next, from the board's log.

    `old` counts motion under the number of a finished turn; `foreign` counts motion that the turn's
    own operator never requested.
    """

    n: int
    old: int
    foreign: int
    without_stop: int


def switches(frames: Iterable[Seen], directions: Mapping[int, int]) -> Switches:
    """Find the switches in all frames on the wire; `directions` is 1 or -1 for each turn."""
    old = foreign = without_stop = n = highest = 0
    mover: Seen | None = None
    stopped = False
    for frame in frames:
        highest = max(highest, frame.turn)
        if not frame.is_motion:
            stopped = True
            continue
        if frame.turn < highest:
            old += 1
            continue
        ahead = frame.left_mmps + frame.right_mmps
        foreign += ahead * directions.get(frame.turn, 0) <= 0
        if mover is not None and frame.turn > mover.turn:
            n += 1
            without_stop += not stopped
        mover, stopped = frame, False
    return Switches(n, old, foreign, without_stop)


async def hand_over(n: int, **settings: Any) -> list[Row]:
    """Let two operators take turns, and drive on wrongly after their turn.

    Most leave; some let the turn end, vanish, crash, or reconnect at that instant.
    """
    random = Random(2004)
    endings = [*ENDINGS, *random.choices(ENDINGS, _WEIGHTS, k=max(0, n - len(ENDINGS) + 1))]
    turns = {"turns": {"turn_s": _TURN_S, "grace_s": 0.5}}
    async with AsyncExitStack() as leaving:
        stage = await leaving.enter_async_context(staged(turns, **settings))
        now, after = Player(stage, 1), Player(stage, -1)
        for player in (now, after):
            leaving.push_async_callback(player.leave)
            await player.come()
        for ending in endings:
            await now.gets_turn()
            after.operator.send(type="join")
            await now.begins()
            await now.ends(ending, random)
            now, after = after, now
        stage.record.read()
        directions = {turn: one.direction for one in (now, after) for turn in one.turns}
        found = switches(stage.record.frames, directions)
    if found.n == 0 and not found.old + found.foreign:
        raise MeasureError("hand-over: there was none")
    what = "hand-over: frames for the old turn, or by its operator's hands; switches without a stop"
    wrong = found.old + found.foreign + found.without_stop
    done: dict[str, int] = {ending: endings.count(ending) for ending in ENDINGS}
    row = counted("hand-over", what, wrong, found.n, **done)
    return [row.model_copy(update={"load": str(stage.load)})]


class Player:
    """One of the two operators, who drives ahead (1) or back (-1), and how their turns end."""

    def __init__(self, stage: Stage, direction: int) -> None:
        self.direction = direction
        self.turns: set[int] = set()
        self.operator: RawOperator
        self._stage = stage
        self._browser = Browser()
        self._relay = Relay()
        self._leaving = AsyncExitStack()

    async def come(self) -> None:
        """Connect, or reconnect by a new path."""
        await self.leave()
        self._relay = Relay()
        self.operator = await self._leaving.enter_async_context(
            RawOperator(
                self._stage.server, browser=self._browser, on_socket=self._relay.tap, persists=True
            )
        )

    async def leave(self) -> None:
        await self._leaving.aclose()

    async def gets_turn(self) -> None:
        """Wait for the turn, and keep joining: a lost viewer may have lost their place."""
        for _ in range(_ASKS):
            if await self.operator.until(lambda: self.operator.has_turn, _ASK_EVERY_S):
                self.turns.add(self.operator.turn)
                return
            self.operator.send(type="join")
        raise MeasureError(f"hand-over: no turn within {_ASKS * _ASK_EVERY_S:g} s")

    async def begins(self) -> None:
        """Release and press at once, as a viewer does who waits for their turn."""
        self.operator.let_go()
        self.operator.steer(self.direction)
        self.operator.command()
        await self._stage.moves(_TURN_S)
        await asyncio.sleep(0.02)

    async def ends(self, ending: Ending, random: Random) -> None:
        """End the turn in one of five ways, while still pressing."""
        left_ms = (self.operator.ends_server_ms or 0.0) - self.operator.server_ms()
        ends_s = time.monotonic() + left_ms / 1000
        match ending:
            case "leave":
                await asyncio.sleep(random.uniform(0.0, 0.1))
                self.operator.send(type="leave")
            case "expire":
                await self.operator.until(lambda: not self.operator.has_turn, 15.0)
            case "vanish":
                # The server notices the loss at about the moment when the turn ends.
                await _until(ends_s - _LOST_S * random.uniform(0.9, 1.1))
                self._relay.cut()
                await asyncio.sleep(_LOST_S * 1.3)
                self._relay.mend()
                if not self.operator.is_open:
                    await self.come()
            case "crash":
                await _until(ends_s - _LOST_S * random.uniform(0.0, 1.1))
                self._relay.cut()
                await self.come()
            case "reconnect":
                await _until(ends_s - random.uniform(0.0, 0.6))
                await self.come()


async def _until(at_s: float) -> None:
    await asyncio.sleep(max(0.0, at_s - time.monotonic()))
