"""From one operator to the next, again and again: no frame of the old turn after the switch."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from itertools import pairwise
from random import Random
from typing import TYPE_CHECKING, Any, Final

from e2e.faults.operator import RawOperator
from e2e.faults.relay import Relay
from e2e.faults.stage import staged
from e2e.measure.errors import MeasureError
from e2e.measure.row import counted, timed

if TYPE_CHECKING:
    from collections.abc import Container, Sequence

    from e2e.faults.record import Seen
    from e2e.faults.stage import Stage
    from e2e.measure.row import Row

GAP_MS: Final = 300.0
TURN_S: Final = 60.0
TURN_ERROR_MS: Final = 100.0
_SHORT_TURN_S: Final = 1.0
_SLOW: Final = ("vanish", "reconnect")
_LOST_S: Final = 1.0
"""After so long without a word the server takes an operator for lost."""


@dataclass(frozen=True, slots=True)
class Switches:
    """What the board's log says about all switches from one turn to the next."""

    n: int
    late: int
    without_stop: int
    gaps_ms: tuple[float, ...]


def switches(frames: Sequence[Seen], slow: Container[int] = ()) -> Switches:
    """Read them off the frames: a late one would move the robot for a turn that is over.

    Turns of `slow` hands are left out of the gaps.
    """
    late = without_stop = n = 0
    gaps_ms: list[float] = []
    highest, began_s = 0, 0.0
    mover: Seen | None = None
    stop_s: float | None = None
    for frame in frames:
        if frame.moves and frame.turn < highest:
            late += 1
        if frame.turn > highest:
            highest, began_s = frame.turn, frame.at_s
        if not frame.moves:
            if mover is not None and stop_s is None:
                stop_s = frame.at_s
            continue
        if mover is not None and frame.turn > mover.turn:
            n += 1
            without_stop += stop_s is None
            if frame.turn not in slow:
                gaps_ms.append((frame.at_s - began_s) * 1000)
        mover, stop_s = frame, None
    return Switches(n, late, without_stop, tuple(gaps_ms))


async def hand_over(n: int, **settings: Any) -> list[Row]:
    """Two who take turns: most leave, some let the turn end, vanish, or come back in that instant.

    The gap is from a turn's first frame, a stop, to its first that moves; who drives lets go and
    presses as soon as he is told. Where the one before vanished or came back, this suite looks
    after that first and presses later: those turns are left out of the gaps, of nothing else.
    """
    random = Random(2004)
    short = {"turns": {"turn_s": _SHORT_TURN_S, "grace_s": 0.5}}
    async with staged(short, **settings) as stage:
        players = [Player(stage), Player(stage)]
        for player in players:
            await player.come()
        players[0].raw.say(type="join")
        kinds = dict.fromkeys(("leave", "expire", *_SLOW), 0)
        slow: set[int] = set()
        try:
            for turn in range(n + 1):
                now, after = players[turn % 2], players[(turn + 1) % 2]
                await now.raw.gets_turn()
                after.raw.say(type="join")
                await now.begins()
                kind = random.choices(list(kinds), weights=(86, 8, 3, 3))[0]
                kinds[kind] += 1
                await now.ends(kind, random)
                await after.raw.gets_turn()
                if kind in _SLOW:
                    slow.add(after.raw.turn)
                await now.is_there()
        finally:
            for player in players:
                await player.go()
        stage.record.read()
        found = switches(stage.record.frames, slow)
    if found.n == 0:
        raise MeasureError("hand-over: there was none")
    return [
        counted(
            "hand-over",
            "hand-over: frames of an old turn after the switch",
            found.late,
            found.n,
            **kinds,
        ),
        counted(
            "hand-over: stop", "… switches without a stop between", found.without_stop, found.n
        ),
        timed(
            "hand-over: gap",
            "… a turn begins → its first motion",
            found.gaps_ms,
            GAP_MS,
        ),
    ]


class Player:
    """One of the two, and what can become of his turn."""

    def __init__(self, stage: Stage) -> None:
        self._stage = stage
        self._relay = Relay()
        self.raw = RawOperator(stage.server, relay=self._relay)

    async def come(self) -> None:
        await self.raw.__aenter__()

    async def go(self) -> None:
        await self.raw.__aexit__(None, None, None)

    async def begins(self) -> None:
        """Let go and press at once, as whoever waits for his turn does."""
        self.raw.let_go()
        self.raw.steer(1.0)
        await self._stage.moves(_SHORT_TURN_S)
        await asyncio.sleep(0.02)

    async def ends(self, kind: str, random: Random) -> None:
        """Let the turn end in one of four ways."""
        match kind:
            case "leave":
                await self.leave(random)
            case "expire":
                await self.expire()
            case "vanish":
                await self.vanish(random)
            case _:
                await self.reconnect(random)

    async def leave(self, random: Random) -> None:
        """Hand over himself, pressing on."""
        await asyncio.sleep(random.uniform(0.0, 0.1))
        self.raw.say(type="leave")

    async def expire(self) -> None:
        """Press on until the turn is over, and after that."""
        while self.raw.has_turn:
            self.raw.told.clear()
            await self.raw.told.wait()

    async def vanish(self, random: Random) -> None:
        """Vanish so that the loss is noticed in the instant in which the turn ends."""
        await self._until_end(_LOST_S * random.uniform(0.9, 1.1))
        self._relay.cut()
        await asyncio.sleep(_LOST_S * 1.3)
        self._relay.mend()

    async def reconnect(self, random: Random) -> None:
        """Come back with a new connection in the instant in which the turn ends."""
        old = self.raw
        relay = Relay()
        again = RawOperator(self._stage.server, client=old.client, relay=relay)
        await self._until_end(random.uniform(0.0, 0.6))
        await again.__aenter__()
        again.steer(1.0)
        self.raw, self._relay = again, relay
        await old.__aexit__(None, None, None)

    async def is_there(self) -> None:
        """Be heard again, whatever became of the connection."""
        if not await self.raw.pongs():
            raise MeasureError("a peer of the hand-over did not come back")

    async def _until_end(self, before_s: float) -> None:
        ends_ms = self.raw.ends_server_ms
        if ends_ms is not None:
            await asyncio.sleep(max(0.0, (ends_ms - self.raw.server_ms()) / 1000 - before_s))


async def one_turn(n: int, *, turn_s: float = TURN_S, **settings: Any) -> Row:
    """Measure how long a whole turn lasts, by its first and last frame."""
    errors_ms: list[float | None] = []
    async with (
        staged({"turns": {"turn_s": turn_s}}, **settings) as stage,
        RawOperator(stage.server) as first,
        RawOperator(stage.server) as second,
    ):
        for _ in range(n):
            await first.join()
            second.say(type="join")
            first.let_go()
            await asyncio.sleep(0.05)
            first.steer(1.0)
            await second.gets_turn(turn_s + 5)
            await asyncio.sleep(0.1)
            stage.record.read()
            frames = stage.record.frames
            begin_s = dict(_first_frames(frames))
            turns = sorted(begin_s)[-2:]
            lasted_s = begin_s[turns[1]] - begin_s[turns[0]]
            errors_ms.append(abs(lasted_s - turn_s) * 1000)
            second.say(type="leave")
    return timed("one-turn", f"turn of {turn_s:g} s: error of its length", errors_ms, TURN_ERROR_MS)


def _first_frames(frames: Sequence[Seen]) -> list[tuple[int, float]]:
    """Give when each turn's first frame came."""
    changes = [(frames[0].turn, frames[0].at_s)] if frames else []
    changes += [(b.turn, b.at_s) for a, b in pairwise(frames) if b.turn > a.turn]
    return changes
