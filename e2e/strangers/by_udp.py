"""Attacks by UDP: with the keys of viewers who were let in, or without any."""

from __future__ import annotations

import socket
from contextlib import suppress
from itertools import cycle
from typing import TYPE_CHECKING, Final

from e2e.strangers import wire
from e2e.strangers.ground import address
from e2e.strangers.intruder import Intruder

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from e2e.strangers.ground import Ground

_FEEDBACKS: Final = 28
"""Of 40 bytes each, in one datagram."""
_NACKED: Final = 128
"""Packets asked for again at once: all that a sender of media usually keeps."""
_A_MS: Final = 40
"""Datagrams, as fast as one core sends them."""


async def rtcp(ground: Ground, rate_hz: float, packets: Callable[[Intruder], bytes]) -> None:
    """Let each viewer send these packets at this rate."""
    async for intruder in ground.turns(rate_hz):
        datagram = packets(intruder)
        await intruder.send_rtcp(datagram)
        ground.account["bytes"] += len(datagram)


def loses_lots(_: Intruder) -> bytes:
    return wire.announces_lost(0, 65_535) * _FEEDBACKS


def wants_all_again(intruder: Intruder) -> bytes:
    asked = [wire.nack(ssrc, newest, _NACKED) for ssrc, newest in intruder.sequence_numbers.items()]
    return wire.receiver_report(1) + b"".join(asked)


async def sctp(ground: Ground, rate_hz: float, kinds: Sequence[bytes]) -> None:
    """Send datagrams full of chunks that demand an answer each, of one kind after the other."""
    datagrams = cycle([wire.full_of(kind) for kind in kinds])
    async for intruder in ground.turns(rate_hz):
        await intruder.send_sctp(next(datagrams))


async def authenticated(ground: Ground) -> None:
    """Send the shortest valid RTCP as fast as one core makes it."""
    report = wire.receiver_report(1)
    async for _ in ground.ticks(0.001):
        for intruder in ground.intruders:
            for _ in range(_A_MS // len(ground.intruders)):
                await intruder.send_rtcp(report)


async def junk(ground: Ground) -> None:
    """Send what is nothing, of every first byte, to the port that everybody shares."""
    # Where media go, as the answer to an offer tells anybody.
    async with Intruder(ground.port, source=address(249)) as scout:
        where = scout.media_address
    pieces = [ground.chance.randbytes(ground.chance.randint(1, 200)) for _ in range(256)]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        stranger.setblocking(False)
        async for _ in ground.ticks(0.001):
            for piece in ground.chance.choices(pieces, k=_A_MS):
                with suppress(OSError):
                    stranger.sendto(piece, where)
                ground.account["datagrams"] += 1
