"""What strangers may do to the server, each by name: ``python -m e2e.public.attacks PORT``.

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
from functools import partial
from typing import Any, Final

from e2e.public import by_http, by_udp, wire
from e2e.public.ground import Attack, Ground, together
from e2e.public.intruder import Intruder
from e2e.public.strangers import OwnTime, address

_TAIL_S: Final = 1.0
"""For answers that are under way when an attack ends."""


async def _mix(ground: Ground) -> None:
    """Draw attacks, as many at once and as long as chance will have it."""
    several = [name for name in ATTACKS if name not in ("mix", "feedback-40")]

    async def some(chance: random.Random) -> None:
        while not ground.is_over:
            name = chance.choice(several)
            lasts_s = chance.uniform(0.3, 3.0)
            some_of_them = chance.sample(list(ground.intruders), chance.randint(1, 4))
            until_s = min(ground.until_s, time.monotonic() + lasts_s)
            ground.account[name] += 1
            with suppress(TimeoutError):
                async with asyncio.timeout(lasts_s + _TAIL_S):
                    await ATTACKS[name].work(Ground(ground.port, some_of_them, until_s, chance))
            await asyncio.sleep(chance.uniform(0.0, 0.5))

    # Each has a chance of its own, so that a seed says all that is drawn.
    await together(some(random.Random(ground.chance.random())) for _ in range(3))


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
    "mix": Attack("all of these, by chance", _mix, 8, True),
}


async def attack(port: int, name: str, seconds: float, seed: int) -> dict[str, Any]:
    """Let the viewers in, say that it begins, attack; return what it cost and what came of it."""
    one = ATTACKS[name]
    async with AsyncExitStack() as leaving:
        intruders = [Intruder(port, source=address(100), sees=one.sees) for _ in range(one.viewers)]
        for intruder in intruders:
            await leaving.enter_async_context(intruder)
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
