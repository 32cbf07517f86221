"""What strangers may do to the server, each by name: ``python -m e2e.strangers.attacks PORT``.

For each line that it reads, the name of an attack, how many seconds it lasts and a seed of chance,
it lets the attack's viewers in, writes an empty line when it begins, and at its end, as JSON, what
was sent and what came back. Each is bounded: in time by that line, in rate by its own in `ATTACKS`.
"""

from __future__ import annotations

import asyncio
import json
import os
import random
import sys
import time
from collections import Counter
from contextlib import AsyncExitStack, suppress
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from e2e.strangers import by_http, by_udp, wire
from e2e.strangers.ground import Attack, Ground, together
from e2e.strangers.intruder import Intruder, NoPlaceError
from e2e.strangers.strangers import OwnTime, address

if TYPE_CHECKING:
    from collections.abc import Iterator

_TAIL_S: Final = 1.0
"""For answers that are under way when an attack ends."""
_FIRST: Final = 100
"""Number of the first address of viewers."""


@dataclass(frozen=True, slots=True)
class Draw:
    """One attack of a mix, by which of its viewers, and with which chance."""

    name: str
    lasts_s: float
    viewers: tuple[int, ...]
    chance: float
    pause_s: float

    def __str__(self) -> str:
        return f"{self.name} {self.lasts_s:.3f} s by {self.viewers}, then {self.pause_s:.3f} s"


def mixed(chance: random.Random) -> list[Iterator[Draw]]:
    """Return what a mix does at once, one row of attacks beside the other, without end."""
    several = [name for name in ATTACKS if name not in (MIX, "feedback-40")]

    def row(own: random.Random) -> Iterator[Draw]:
        while True:
            yield Draw(
                own.choice(several),
                own.uniform(0.3, 3.0),
                tuple(own.sample(range(ATTACKS[MIX].viewers), own.randint(1, 4))),
                own.random(),
                own.uniform(0.0, 0.5),
            )

    # Nobody else draws from them, so that a seed says all of it, however quickly it goes.
    return [row(random.Random(chance.random())) for _ in range(3)]


async def _mix(ground: Ground) -> None:
    """Attack as chance will have it."""

    async def some(row: Iterator[Draw], drawn: list[str]) -> None:
        while not ground.is_over:
            draw = next(row)
            drawn.append(str(draw))
            ground.account[draw.name] += 1
            some_of_them = [ground.intruders[number] for number in draw.viewers]
            until_s = min(ground.until_s, time.monotonic() + draw.lasts_s)
            own = Ground(ground.port, some_of_them, until_s, random.Random(draw.chance))
            with suppress(TimeoutError):
                async with asyncio.timeout(draw.lasts_s + _TAIL_S):
                    await ATTACKS[draw.name].work(own)
            await asyncio.sleep(draw.pause_s)

    rows = mixed(ground.chance)
    ground.drawn = [[] for _ in rows]
    await together(some(*one) for one in zip(rows, ground.drawn, strict=True))


MIX: Final = "mix"
_LOST: Final = "transport feedback about 65,535 lost packets, 28 in a datagram"

ATTACKS: Final[dict[str, Attack]] = {
    "feedback-1": Attack(
        f"{_LOST}: 1 viewer, 4/s",
        partial(by_udp.rtcp, rate_hz=4, packets=by_udp.loses_lots),
        1,
        True,
    ),
    "feedback-4": Attack(
        f"{_LOST}: 4 viewers, 3/s each",
        partial(by_udp.rtcp, rate_hz=3, packets=by_udp.loses_lots),
        4,
        True,
    ),
    "feedback-40": Attack(
        f"{_LOST}: 40 viewers, 3/s each",
        partial(by_udp.rtcp, rate_hz=3, packets=by_udp.loses_lots),
        40,
        True,
    ),
    "nacks": Attack(
        "4 viewers ask for everything again, 60/s each",
        partial(by_udp.rtcp, rate_hz=60, packets=by_udp.wants_all_again),
        4,
        True,
    ),
    "heartbeats": Attack(
        "285 heartbeats of SCTP a datagram: 4 viewers, 20/s each",
        partial(by_udp.sctp, rate_hz=20, kinds=wire.DEMANDING[:1]),
        4,
    ),
    "chunks": Attack(
        "heartbeats, shutdowns and resets of SCTP, full datagrams: 4 viewers, 20/s each",
        partial(by_udp.sctp, rate_hz=20, kinds=wire.DEMANDING),
        4,
    ),
    "authenticated": Attack("4 viewers send RTCP as fast as they can", by_udp.authenticated, 4),
    "junk": Attack("datagrams of nothing as fast as they can be sent", by_udp.junk),
    "pipelined": Attack(
        "the page again and again, 20 requests at once: 60 connections of one address",
        partial(
            by_http.pipelined, connections=60, addresses=1, rate_hz=20_000, request=by_http.PAGE
        ),
    ),
    "cookies-1": Attack(
        "64 KB of cookies a request: 32 connections of one address",
        partial(
            by_http.pipelined, connections=32, addresses=1, rate_hz=400, request=by_http.COOKIES
        ),
    ),
    "cookies-4": Attack(
        "64 KB of cookies a request: 128 connections of 4 addresses",
        partial(
            by_http.pipelined, connections=128, addresses=4, rate_hz=400, request=by_http.COOKIES
        ),
    ),
    "never-read": Attack(
        "640 connections from 12 addresses that never read",
        partial(by_http.never_read, connections=640, addresses=12),
    ),
    "slow": Attack(
        "500 connections from 50 addresses that say nothing, or too little",
        partial(by_http.dawdle, connections=500, addresses=50),
    ),
    "empty-offers": Attack(
        "160 empty offers a second of one address",
        partial(by_http.offers, rate_hz=160, sources=1, empty=True),
    ),
    "offers-1": Attack(
        "200 offers a second from one address",
        partial(by_http.offers, rate_hz=200, sources=1, empty=False),
    ),
    "offers-50": Attack(
        "200 offers a second from 50 addresses",
        partial(by_http.offers, rate_hz=200, sources=50, empty=False),
    ),
    MIX: Attack("all of these, by chance", _mix, 8, True),
}


async def _let_in(port: int, one: Attack, leaving: AsyncExitStack) -> list[Intruder]:
    """Let its viewers in, of as few addresses as may have so many."""
    found: list[Intruder] = []
    number = _FIRST
    while len(found) < one.viewers:
        intruder = Intruder(port, source=address(number), sees=one.sees)
        try:
            found.append(await leaving.enter_async_context(intruder))
        except NoPlaceError:
            number += 1
    return found


async def attack(port: int, name: str, seconds: float, seed: int) -> dict[str, Any]:
    """Let the viewers in, say that it begins, attack; return what it cost and what came of it."""
    one = ATTACKS[name]
    async with AsyncExitStack() as leaving:
        intruders = await _let_in(port, one, leaving)
        print(flush=True)
        own = OwnTime()
        before = sum((intruder.counts for intruder in intruders), Counter[str]())
        ground = Ground(port, intruders, time.monotonic() + seconds, random.Random(seed))
        with suppress(TimeoutError):
            async with asyncio.timeout(seconds + _TAIL_S):
                await one.work(ground)
        counts = sum((intruder.counts for intruder in intruders), Counter[str]())
        counts.subtract(before)
        return {
            "did": dict(ground.account),
            "lasted_s": ground.lasted_s,
            "drawn": ground.drawn,
            "datagrams": dict(counts),
            "left": sum(intruder.is_connected for intruder in intruders),
            "cpu_share": own.share(),
        }


async def _serve(port: int) -> None:
    os.nice(19)  # in life they have machines of their own
    print(flush=True)
    while line := (await asyncio.to_thread(sys.stdin.readline)).split():
        name, seconds, seed = line
        print(json.dumps(await attack(port, name, float(seconds), int(seed))), flush=True)


if __name__ == "__main__":
    asyncio.run(_serve(int(sys.argv[1])))
