"""The attacks of strangers on the server, by name: ``python -m e2e.strangers.attacks PORT``.

Each line that it reads has an attack's name, its seconds and a random seed. It lets the attack's
viewers join and writes an empty line when the attack begins; at its end it writes what was sent and
received, as JSON. The line bounds the attack's time, and `ATTACKS` its rate.
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
from typing import TYPE_CHECKING, Any, Final

from e2e.strangers import by_channel, by_dtls, by_http, by_ice, by_udp, wire
from e2e.strangers.ground import Attack, Ground, address, together
from e2e.strangers.intruder import Intruder, NoPlaceError

if TYPE_CHECKING:
    from collections.abc import Callable

_JOINING_S: Final = 20.0
"""However many viewers an attack wants: their own ends share this machine, and many that receive
pictures keep others from connecting in time."""
_TAIL_S: Final = 1.0
"""For answers still in flight when an attack ends."""
_FIRST: Final = 100
"""The number of the viewers' first address."""


async def _mix(ground: Ground) -> None:
    """Run random attacks, three at once."""
    let_in = len(ground.intruders)
    several = [
        name
        for name, one in ATTACKS.items()
        if name not in (MIX, ALL, "chains", "feedback-40", "slow") and one.viewers <= let_in
    ]

    async def row(own: random.Random) -> None:  # one generator each, so that a seed repeats it
        while not ground.is_over:
            name, lasts_s = own.choice(several), own.uniform(0.3, 3.0)
            some = own.sample(range(let_in), min(own.randint(1, 4), let_in))
            ground.account[name] += 1
            until_s = min(ground.until_s, time.monotonic() + lasts_s)
            there = [ground.intruders[number] for number in some]
            part = Ground(ground.port, there, until_s, random.Random(own.random()))
            # Another attack may have ended this one's viewers.
            with suppress(TimeoutError, ConnectionError):
                async with asyncio.timeout(lasts_s + _TAIL_S):
                    await ATTACKS[name].work(part)
            await asyncio.sleep(own.uniform(0.0, 0.5))

    await together(row(random.Random(ground.chance.random())) for _ in range(3))


async def _every(ground: Ground) -> None:
    """Run each of the others, all the time."""
    await together(one.work(ground) for name, one in ATTACKS.items() if name not in (MIX, ALL))


async def _talk(ground: Ground) -> None:
    await together(ATTACKS[name].work(ground) for name in ("wants", "queue", "renames"))


def _feedback(viewers: int, rate_hz: float) -> Attack:
    who = "1 viewer" if viewers == 1 else f"{viewers} viewers"
    what = f"transport feedback about 65,535 lost packets, 28 in a datagram: {who}, {rate_hz:g}/s"
    return Attack(
        what, partial(by_udp.rtcp, rate_hz=rate_hz, packets=by_udp.loses_lots), viewers, True
    )


def _asks(what: str, connections: int, addresses: int, rate_hz: float, request: bytes) -> Attack:
    where = "one address" if addresses == 1 else f"{addresses} addresses"
    work = partial(
        by_http.pipelined,
        connections=connections,
        addresses=addresses,
        rate_hz=rate_hz,
        request=request,
    )
    return Attack(f"{what}: {connections} connections of {where}", work)


def _offers(what: str, rate_hz: float, sources: int, shaped: Callable[[str], str] = str) -> Attack:
    return Attack(what, partial(by_http.offers, rate_hz=rate_hz, sources=sources, shaped=shaped))


MIX: Final = "mix"
ALL: Final = "all"
ATTACKS: Final[dict[str, Attack]] = {
    "feedback-1": _feedback(1, 4),
    "feedback-4": _feedback(4, 3),
    "feedback-40": _feedback(40, 3),
    "nacks": Attack(
        "4 viewers ask for everything again, 60/s each",
        partial(by_udp.rtcp, rate_hz=60, packets=by_udp.wants_all_again), 4, True,
    ),
    "heartbeats": Attack(
        "285 heartbeats of SCTP a datagram: 4 viewers, 20/s each",
        partial(by_udp.sctp, rate_hz=20, kinds=wire.DEMANDING[:1]), 4,
    ),
    "chunks": Attack(
        "heartbeats, shutdowns and resets of SCTP, full datagrams: 4 viewers, 20/s each",
        partial(by_udp.sctp, rate_hz=20, kinds=wire.DEMANDING), 4,
    ),
    "authenticated": Attack("4 viewers send RTCP as fast as they can", by_udp.authenticated, 4),
    "wants": Attack(
        "20 viewers want another size or policy each second",
        partial(by_channel.says, rate_hz=1, messages=by_channel.WANTS), 20, True,
    ),
    "queue": Attack(
        "20 viewers join the queue and leave it, 5/s each",
        partial(by_channel.says, rate_hz=5, messages=by_channel.QUEUE), 20,
    ),
    "renames": Attack(
        "40 viewers of one address rename in step, by what is 18 characters for each",
        partial(by_channel.renames, rate_hz=1), 40,
    ),
    "talk": Attack("12 viewers do these three together", _talk, 12, True),
    "junk": Attack("datagrams of nothing as fast as they can be sent", by_udp.junk),
    "pipelined": _asks("the page, 20 requests at once", 60, 1, 20_000, by_http.PAGE),
    "cookies-1": _asks("64 KB of cookies a request", 32, 1, 400, by_http.COOKIES),
    "cookies-4": _asks("64 KB of cookies a request", 128, 4, 400, by_http.COOKIES),
    "crumbs": _asks("a body of 10,000 chunks of a byte", 40, 3, 400, by_http.CRUMBS),
    "keys": _asks("a body of 7,000 unknown keys", 24, 1, 400, by_http.KEYS),
    "releases": Attack(
        "10 viewers who may not release a Stop ask for it, 20 requests at once, on 48 connections",
        partial(by_http.releases, connections=48, rate_hz=20_000), 10, apart=True,
    ),
    "unfinished": Attack(
        "640 connections from 12 addresses that send all of a body but its last byte",
        partial(by_http.unfinished, connections=640, addresses=12),
    ),
    "never-read": Attack(
        "640 connections from 12 addresses that never read",
        partial(by_http.never_read, connections=640, addresses=12),
    ),
    "resets": Attack(
        "1,500 connections a second from 20 addresses, each reset at once",
        partial(by_http.resets, rate_hz=1500, addresses=20),
    ),
    "crowd": _asks("a cheap request, one connection each", 200, 200, 20_000, by_http.HEALTH),
    "slow": Attack(
        "500 connections from 50 addresses that say nothing, or too little",
        partial(by_http.dawdle, connections=500, addresses=50),
    ),
    "empty-offers": _offers("160 empty offers a second of one address", 160, 1, lambda _: ""),
    "offers-1": _offers("200 offers a second from one address", 200, 1),
    "offers-20": _offers("50 offers a second from 20 addresses", 50, 20),
    "offers-50": _offers("200 offers a second from 50 addresses", 200, 50),
    "wide-offers": _offers("10 offers a second of five long pictures", 10, 5, wire.wide),
    "chains": Attack(
        "4 handshakes a second from 4 addresses with a chain of 40 or 80 certificates",
        partial(by_dtls.chains, rate_hz=4, sources=4), prepare=by_dtls.made,
    ),
    "swaps": Attack(
        "a viewer swaps two paths of its own, 100/s", partial(by_ice.swaps, rate_hz=100), 1, True
    ),
    MIX: Attack("all of these, by chance", _mix, 10, True),
    ALL: Attack("all of these at once", _every, 20, True, prepare=by_dtls.made),
}  # fmt: skip


async def _let_in(port: int, one: Attack, leaving: AsyncExitStack) -> list[Intruder]:
    """Let the attack's viewers join, from as few addresses as allowed, as far as there is room."""
    found: list[Intruder] = []
    with suppress(TimeoutError):
        async with asyncio.timeout(_JOINING_S):
            for source in map(address, range(_FIRST, _FIRST + one.viewers)):
                with suppress(NoPlaceError):
                    while len(found) < one.viewers:
                        intruder = Intruder(port, source=source, sees=one.sees)
                        found.append(await leaving.enter_async_context(intruder))
                        if one.apart:
                            break
    return found


async def attack(port: int, name: str, seconds: float, seed: int) -> dict[str, Any]:
    """Let the viewers join, signal the start, and attack; return what was sent and received."""
    one = ATTACKS[name]
    await asyncio.to_thread(one.prepare)
    async with AsyncExitStack() as leaving:
        intruders = await _let_in(port, one, leaving)
        print(flush=True)
        before = sum((intruder.counts for intruder in intruders), Counter[str]())
        ground = Ground(port, intruders, time.monotonic() + seconds, random.Random(seed))
        with suppress(TimeoutError):
            async with asyncio.timeout(seconds + _TAIL_S):
                await one.work(ground)
        counts = sum((intruder.counts for intruder in intruders), Counter[str]())
        counts.subtract(before)
        return {
            "viewers": len(intruders),
            "did": dict(ground.account),
            "lasted_s": ground.lasted_s,
            "datagrams": dict(counts),
            "left": sum(intruder.is_connected for intruder in intruders),
        }


async def _serve(port: int) -> None:
    os.nice(19)  # below the server's priority: real attackers have machines of their own
    print(flush=True)
    while line := (await asyncio.to_thread(sys.stdin.readline)).split():
        name, seconds, seed = line
        print(json.dumps(await attack(port, name, float(seconds), int(seed))), flush=True)


if __name__ == "__main__":
    asyncio.run(_serve(int(sys.argv[1])))
