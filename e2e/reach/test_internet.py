"""The small internet's routers behave like a household's, as seen from two places outside."""

from __future__ import annotations

import asyncio
import json
from typing import Final

import pytest

from e2e.reach.internet import Host, Internet
from e2e.reach.stage import FRIEND, MEDIA, ROBOT, TURN

OTHER: Final = Host("other", "203.0.113.10")
CARRIED: Final = Host("friend", "192.168.7.2", public="100.64.0.2", carrier="203.0.113.2")
TELLS: Final = f"""
import socket
line = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
line.bind(("", {MEDIA}))
print(flush=True)
while True:
    _, sender = line.recvfrom(99)
    line.sendto(repr(sender).encode(), sender)
    line.sendto(b"pushed", ("203.0.113.2", 50_001))
"""
"""Answers each datagram with its source, and sends one more datagram that nobody asked for."""
ASKS: Final = f"""
import ast, json, socket, sys
line, silent = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
line.bind(("", 50_000)), silent.bind(("", 50_001))
line.settimeout(2), silent.settimeout(0.2)
def ask(where):
    line.sendto(b"?", (where, {MEDIA}))
    try:
        return ast.literal_eval(line.recv(99).decode())
    except OSError:
        return None
seen = [ask(where) for where in sys.argv[1:]]
try:
    seen.append(silent.recv(99).decode())
except OSError:
    pass
print(json.dumps(seen))
"""


async def _asked(net: Internet, *where: str) -> list[tuple[str, int] | None]:
    """Return the source that each of `where` sees of one socket at the friend's: address, port."""
    pipe = asyncio.subprocess.PIPE
    asking = await net["friend"].spawn_python(["-c", ASKS, *where], stdout=pipe)
    said, _ = await asking.communicate()
    return [None if one is None else tuple(one) for one in json.loads(said)]


@pytest.mark.full
@pytest.mark.parametrize(
    "friend",
    [
        FRIEND,
        Host("friend", "192.168.7.2", public="203.0.113.2", symmetric=True),
        Host("friend", "192.168.7.2", public="203.0.113.2", udp=False),
        CARRIED,
        Host("friend", "192.168.1.3", public=ROBOT.public),
    ],
    ids=["home", "symmetric", "no UDP", "carrier", "the robot's home"],
)
async def test_a_router_lets_through_what_it_would(friend: Host) -> None:
    """It translates once or twice, lets in only answers, and forwards a port to everybody."""
    async with Internet(ROBOT, friend, TURN, OTHER) as net:
        for name in ("robot", "turn", "other"):
            telling = await net[name].spawn_python(["-c", TELLS], stdout=asyncio.subprocess.PIPE)
            assert telling.stdout is not None
            await telling.stdout.readline()
        first, second, robot = await _asked(net, TURN.address, OTHER.address, ROBOT.public or "")
        if not friend.udp:
            assert first is second is robot is None
            return
        assert first is not None
        assert second is not None
        assert first[0] == second[0] == (friend.carrier or friend.public)
        assert (first[1] == second[1]) is not friend.symmetric
        assert robot is not None
        if friend.symmetric:
            await net.forget("friend")
            again, *_ = await _asked(net, TURN.address)
            assert again not in (None, first)
