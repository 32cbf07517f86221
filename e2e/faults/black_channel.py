"""The channel as an enemy: what is damaged, repeated, late or another's moves and releases nothing.

Right commands go ahead, wrong ones go back: a frame that goes back is a wrong execution.
"""

from __future__ import annotations

import asyncio
import json
import time
from dataclasses import dataclass
from random import Random
from typing import TYPE_CHECKING, Any, Final

from e2e.faults.finding import Figure, counted
from e2e.faults.operator import RawOperator
from e2e.faults.stage import BLIND, staged
from e2e.harness.wait import eventually

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

_BACK: Final = -1.0
_ROOM_S: Final = 0.04
"""The server takes a hundred messages a second; the beat has fifty of them."""
_STOP_EVERY: Final = 10
"""Each tenth trace is about stop and release, of which a page may send twenty a second."""

HURTS: Final = (
    "corrupted",
    "repeated",
    "reordered",
    "delayed",
    "from the future",
    "of an old turn",
    "of a later turn",
    "foreign",
    "let go",
)
RELEASES: Final = ("corrupted", "repeated", "delayed", "of another stop", "foreign")


@dataclass(slots=True)
class Wrong:
    """What was executed that should not have been."""

    drives: int = 0
    stops: int = 0
    releases: int = 0


async def black_channel(n: int, **settings: Mapping[str, Any]) -> list[Figure]:
    """Send `n` traces of wrong messages between right ones, over real data channels."""
    random = Random(2004)
    async with (
        staged(BLIND, settings) as stage,
        RawOperator(stage.server) as operator,
        RawOperator(stage.server) as stranger,
    ):
        await operator.join()
        # A second turn, so that there is an old one.
        await operator.leave()
        await operator.join()
        await stage.drive(operator)
        begun_s = time.monotonic()
        done = dict.fromkeys(HURTS, 0) | {f"release {name}": 0 for name in RELEASES}
        wrong = Wrong()
        ahead = 0
        for number in range(n):
            if number % _STOP_EVERY == 0:
                hurt = random.choice(RELEASES)
                await _release(operator, stranger, hurt, wrong, random)
                done[f"release {hurt}"] += 1
                await stage.drive(operator)
                ahead += 1
            else:
                hurt = random.choice(HURTS)
                await _drive(operator, stranger, hurt, random)
                done[hurt] += 1
            await asyncio.sleep(_ROOM_S * random.uniform(0.8, 1.2))
        await asyncio.sleep(0.5)
        stage.record.read()
        frames = stage.record.between(begun_s, time.monotonic())
        wrong.drives = sum(frame.left_mmps < 0 or frame.right_mmps < 0 for frame in frames)
        right = sum(frame.moves for frame in frames)
    return [
        counted(
            "black-channel",
            "wrong executions of drive, stop and release",
            wrong.drives + wrong.stops + wrong.releases,
            n,
            by_kind=done,
            wrong_drives=wrong.drives,
            wrong_stops=wrong.stops,
            wrong_releases=wrong.releases,
            right_frames=right,
            pressed_anew=ahead,
        )
    ]


async def _drive(operator: RawOperator, stranger: RawOperator, hurt: str, random: Random) -> None:
    """Send one command back that must not be obeyed."""
    match hurt:
        case "repeated" | "reordered":
            # Sent in its time it would be right; it comes after newer ones have.
            row = operator.row(operator.next_seq(), linear=_BACK, held=True)
            operator.command()
            await asyncio.sleep(random.uniform(0.03, 0.1))
            operator.drive.send(row)
            if hurt == "repeated":
                operator.drive.send(row)
        case "foreign":
            row = operator.row(operator.next_seq() + 10_000, linear=_BACK, held=True)
            stranger.drive.send(row)
        case "let go":
            # The dead-man is not held, whatever the numbers say.
            row = operator.row(operator.next_seq(), linear=_BACK, held=False)
            operator.drive.send(row)
        case _:
            operator.drive.send(_hurt(operator, hurt, random))


def _hurt(operator: RawOperator, hurt: str, random: Random) -> str:
    seq = operator.next_seq()
    now_ms = operator.server_ms()
    other: dict[str, Callable[[], Any]] = {
        "delayed": lambda: {"sent_server_ms": now_ms - random.uniform(400, 5000)},
        "from the future": lambda: {"sent_server_ms": now_ms + random.uniform(1000, 5000)},
        "of an old turn": lambda: {"turn": operator.turn - 1},
        "of a later turn": lambda: {"turn": operator.turn + random.randint(1, 3)},
        "corrupted": dict,
    }
    row = operator.row(seq, linear=_BACK, held=True, **other[hurt]())
    return corrupted(row, random) if hurt == "corrupted" else row


def corrupted(text: str, random: Random) -> str:
    """Damage a text so that it cannot be meant: it is cut, torn, or holds what is no number."""
    match random.randrange(5):
        case 0:
            return text[: random.randrange(1, len(text) - 1)]
        case 1:
            return text.replace("-1.0", random.choice(("NaN", "-Infinity", "-1.5", "null", '"x"')))
        case 2:
            return text.replace("true", random.choice(("1", "null", '"true"', "tru")))
        case 3:
            at = random.randrange(len(text))
            return text[:at] + random.choice("{}\x00\\") + text[at:]
        case _:
            return text[:-1] + "," + random.choice(("0", "null", "[]")) + "]"


async def _release(
    operator: RawOperator, stranger: RawOperator, hurt: str, wrong: Wrong, random: Random
) -> None:
    """Press Stop, then ask wrongly for its release; at the end release it rightly."""
    operator.say(type="stop", really=True)
    operator.state.send('{"type":"stop"')
    await asyncio.sleep(0.05)
    wrong.stops += operator.stopped is not None
    operator.say(type="stop")
    await eventually(lambda: _is(operator, stopped=True), "the stop is latched", every_s=0.01)
    stop = operator.stopped
    assert stop is not None
    now_ms = operator.server_ms()
    match hurt:
        case "corrupted":
            whole = {"type": "release", "stop": stop, "sent_server_ms": now_ms}
            torn = json.dumps(whole)[: random.randrange(5, 30)]
            operator.state.send(torn)
            operator.say(**(whole | {"stop": float(stop) + 0.5}))
            operator.say(**(whole | {"sent_server_ms": str(now_ms)}))
        case "repeated":
            # The release of an earlier stop, once more.
            operator.say(type="release", stop=max(0, stop - 1), sent_server_ms=now_ms)
        case "delayed":
            late_ms = random.uniform(2500, 9000)
            operator.say(type="release", stop=stop, sent_server_ms=now_ms - late_ms)
        case "of another stop":
            operator.say(type="release", stop=stop + random.randint(1, 9), sent_server_ms=now_ms)
        case _:
            stranger.release(stop)
    await asyncio.sleep(0.08)
    wrong.releases += operator.stopped != stop
    operator.let_go()
    await asyncio.sleep(0.04)
    operator.release(stop)
    await eventually(lambda: _is(operator, stopped=False), "the stop is released", every_s=0.01)


async def _is(operator: RawOperator, *, stopped: bool) -> bool:
    return (operator.stopped is not None) is stopped
