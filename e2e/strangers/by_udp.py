"""Attacks by UDP: with the keys of admitted viewers, or without any."""

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
"""Feedback packets of 40 bytes in a datagram."""
_NACKED: Final = 128
"""Packets in one NACK: all that a media sender usually keeps for retransmission."""
_A_MS: Final = 40
"""Datagrams per millisecond: as many as one core sends."""


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
    """Send datagrams full of chunks that each demand an answer, one kind per datagram."""
    datagrams = cycle([wire.full_of(kind) for kind in kinds])
    async for intruder in ground.turns(rate_hz):
        await intruder.send_sctp(next(datagrams))


async def authenticated(ground: Ground) -> None:
    """Send the shortest valid RTCP as fast as one core encrypts it."""
    report = wire.receiver_report(1)
    async for _ in ground.ticks(0.001):
        for intruder in ground.intruders:
            for _ in range(_A_MS // len(ground.intruders)):
                await intruder.send_rtcp(report)


async def junk(ground: Ground) -> None:
    """Send random bytes to the port that everybody shares."""
    # The media port, which anybody learns from the answer to an offer.
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
