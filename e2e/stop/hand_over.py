"""Hands over from one operator to the next, repeatedly: nothing of the old turn may follow.

What is counted is what was on the wire, whether the board took it or not: it refuses an old turn
itself. Each of the two operators drives in a direction of its own, so that a frame tells by its
number which turn it is for, and by its wheels which operator drives.
"""

from __future__ import annotations

import asyncio
from contextlib import AsyncExitStack
from dataclasses import dataclass
from itertools import pairwise
from random import Random
from time import monotonic
from typing import TYPE_CHECKING, Any, Final, Literal, get_args

from e2e.measure.errors import MeasureError
from e2e.measure.row import counted, timed
from e2e.stop.operator import RawOperator
from e2e.stop.stage import staged
from wax.commands.proof.remote import RemoteOperator

if TYPE_CHECKING:
    from collections.abc import Container, Iterator, Mapping, Sequence

    from e2e.measure.row import Row
    from e2e.stop.record import Seen
    from e2e.stop.stage import Stage
    from wax.client.process import OperatorState, Order

GAP_MS: Final = 300.0
TURN_S: Final = 60.0
TURN_ERROR_MS: Final = 100.0
_SHORT_TURN_S: Final = 1.0
_LOST_S: Final = 1.0
"""The server considers an operator lost after this long without a message."""
_WAIT_S: Final = 15.0
_ASKS: Final = 15
_ASK_EVERY_S: Final = 1.5

Ending = Literal["leave", "expire", "vanish", "crash", "reconnect"]
_WEIGHTS: Final[dict[Ending, int]] = {
    "leave": 83,
    "expire": 8,
    "vanish": 3,
    "crash": 3,
    "reconnect": 3,
}
_SLOW: Final = ("vanish", "crash", "reconnect")


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
    gaps_ms: tuple[float, ...]


def switches(
    frames: Sequence[Seen], directions: Mapping[int, int], slow: Container[int] = ()
) -> Switches:
    """Find the switches in all frames on the wire.

    `directions` is 1 or -1 for each turn, by its operator; turns of `slow` ones are left out of
    the gaps.
    """
    old = foreign = without_stop = n = 0
    gaps_ms: list[float] = []
    highest, began_s = 0, 0.0
    mover: Seen | None = None
    stop_s: float | None = None
    for frame in frames:
        if frame.turn > highest:
            highest, began_s = frame.turn, frame.at_s
        if not frame.is_motion:
            if mover is not None and stop_s is None:
                stop_s = frame.at_s
            continue
        if frame.turn < highest:
            old += 1
            continue
        ahead = frame.left_mmps + frame.right_mmps
        foreign += ahead * directions.get(frame.turn, 0) <= 0
        if mover is not None and frame.turn > mover.turn:
            n += 1
            without_stop += stop_s is None
            if frame.turn not in slow:
                gaps_ms.append((frame.at_s - began_s) * 1000)
        mover, stop_s = frame, None
    return Switches(n, old, foreign, without_stop, tuple(gaps_ms))


async def hand_over(n: int, **settings: Any) -> list[Row]:
    """Two who take turns, each a process that drives on after its turn as nobody should.

    Most leave; some let the turn end, vanish, crash, or come back in that instant. The gap is from
    a turn's first frame, a stop, to its first that moves; whoever drives lets go and presses as
    soon as they are told. Where the one before vanished, crashed or came back, this suite looks
    after that first and presses later: those turns are left out of the gaps, of nothing else.
    """
    random = Random(2004)
    short = {"turns": {"turn_s": _SHORT_TURN_S, "grace_s": 0.5}}
    done = dict.fromkeys(_WEIGHTS, 0)
    slow: set[int] = set()
    async with staged(short, **settings) as stage:
        async with AsyncExitStack() as leaving:
            players = Player(stage, 1), Player(stage, -1)
            for player in players:
                leaving.push_async_callback(player.remote.kill)
                await player.come()
            now, after = players
            now.remote.tell("join")
            before: Ending = "leave"
            for ending in _endings(n + 1, random):
                await now.gets_turn()
                after.remote.tell("join")
                if before in _SLOW:
                    slow.add(now.remote.state.turn)
                await now.begins()
                await now.ends(ending, random)
                await after.gets_turn()
                await now.is_there()
                done[ending] += 1
                now, after, before = after, now, ending
        stage.record.read()
        directions = {turn: one.direction for one in players for turn in one.turns}
        found = switches(stage.record.frames, directions, slow)
    if found.n == 0 and not found.old + found.foreign:
        raise MeasureError("hand-over: there was none")
    return [
        counted(
            "hand-over",
            "hand-over: frames on the wire for the old turn, or by its operator's hands",
            found.old + found.foreign,
            found.n,
            of_the_old_turn=found.old,
            of_the_operator_before=found.foreign,
            **done,
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


def _endings(n: int, random: Random) -> Iterator[Ending]:
    """Yield each once, so that a short run has all, and then as often as its weight."""
    once: tuple[Ending, ...] = get_args(Ending)
    yield from once[:n]
    yield from random.choices(list(_WEIGHTS), weights=list(_WEIGHTS.values()), k=max(0, n - 5))


class Player:
    """One of the two, who drives ahead (1) or back (-1), and the ends of a turn."""

    def __init__(self, stage: Stage, direction: int) -> None:
        self.direction = direction
        self.turns: set[int] = set()
        log = stage.server.log_path.with_name(f"operator{direction}.log")
        self.remote = RemoteOperator(log, self._told)
        self._stage = stage

    async def come(self) -> None:
        await self.remote.start(self._stage.server.url)

    async def gets_turn(self) -> None:
        """Wait for the turn, and keep joining: a lost viewer may have lost their place."""
        for _ in range(_ASKS):
            if await self.remote.until(lambda: self.remote.state.drives, _ASK_EVERY_S):
                return
            self.remote.tell("join")
        raise MeasureError(f"hand-over: no turn within {_ASKS * _ASK_EVERY_S:g} s")

    async def begins(self) -> None:
        """Release and press at once, as a viewer who waits for their turn does."""
        press: Order = "drive" if self.direction > 0 else "reverse"
        self.remote.tell("neutral")
        self.remote.tell(press)
        await self._stage.moves(_SHORT_TURN_S)
        await asyncio.sleep(0.02)

    async def ends(self, ending: Ending, random: Random) -> None:
        """Let the turn end in one of five ways, pressing on."""
        match ending:
            case "leave":
                await asyncio.sleep(random.uniform(0.0, 0.1))
                self.remote.tell("leave")
            case "expire":
                await self.remote.until(lambda: not self.remote.state.drives, _WAIT_S)
            case "vanish":
                # The server notices the loss at about the moment when the turn ends.
                await self._until_end(_LOST_S * random.uniform(0.9, 1.1))
                self.remote.freeze()
                await asyncio.sleep(_LOST_S * 1.3)
                self.remote.thaw()
            case "crash":
                await self._until_end(_LOST_S * random.uniform(0.0, 1.1))
                await self.remote.kill()
            case "reconnect":
                await self._until_end(random.uniform(0.0, 0.6))
                self.remote.tell("reconnect")

    async def is_there(self) -> None:
        """Make sure that it is connected; reopen a crashed page."""
        if not self.remote.runs:
            await self.come()
        if not await self.remote.until(lambda: self.remote.state.is_open, _WAIT_S):
            raise MeasureError(f"hand-over: an operator is not back: {self.remote.last_line()}")

    async def _until_end(self, before_s: float) -> None:
        ends_ms = self.remote.state.ends_ms
        if ends_ms is not None:
            await asyncio.sleep(max(0.0, ends_ms / 1000 - before_s - monotonic()))

    def _told(self, state: OperatorState) -> None:
        if state.drives:
            self.turns.add(state.turn)


async def one_turn(n: int, *, turn_s: float = TURN_S, **settings: Any) -> Row:
    """Return the length of a whole turn, from its first to its last frame."""
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
    """Return when each turn's first frame came."""
    changes = [(frames[0].turn, frames[0].at_s)] if frames else []
    changes += [(b.turn, b.at_s) for a, b in pairwise(frames) if b.turn > a.turn]
    return changes
