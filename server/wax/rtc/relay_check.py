"""Checks whether a TURN server relays between two clients, as it must if both ends use it."""

from __future__ import annotations

import asyncio
import datetime
import socket
from typing import Final
from urllib.parse import parse_qs

from aioice import stun, turn

from wax.rtc.stun_query import StunError, split
from wax.unreachable import Target, why

_ANSWER_S: Final = 6.0
_SENT: Final = b"WAX asks whether you relay"
_AGAIN_S: Final = 0.3


class _End(asyncio.DatagramProtocol):
    def __init__(self) -> None:
        self.heard = asyncio.Event()

    def datagram_received(self, data: bytes, addr: object) -> None:  # noqa: ARG002  # asyncio's form
        if data == _SENT:
            self.heard.set()


def problem(url: str, username: str, credential: str) -> str | None:
    """Return why the server at this ``turn:`` or ``turns:`` address does not relay; blocks."""
    scheme, _, rest = url.partition(":")
    where, _, query = rest.partition("?")
    transport = parse_qs(query).get("transport", ["udp"])[0]
    try:
        host, port = split(where)
        relays = _relay(scheme, host, port, transport, (username, credential))
        asyncio.run(asyncio.wait_for(relays, _ANSWER_S))
    except (TimeoutError, stun.TransactionTimeout):
        return "nothing comes through"
    except stun.TransactionFailed as error:
        return f"it refuses ({error.response.attributes['ERROR-CODE'][1]})"
    except StunError as error:
        return str(error)
    except OSError as error:
        target = Target(scheme, host, port, _ANSWER_S)
        return str(why(target, error, datetime.datetime.now(datetime.UTC), connecting=True))
    return None


async def _relay(
    scheme: str, host: str, port: int, transport: str, secrets: tuple[str, str]
) -> None:
    loop = asyncio.get_running_loop()
    found = await loop.getaddrinfo(host, port, type=socket.SOCK_DGRAM)
    # TLS needs the name; for UDP aioice needs an address.
    server = (host if scheme == "turns" else str(found[0][4][0]), port)
    ends = []
    try:
        for _ in range(2):
            made = await turn.create_turn_endpoint(
                _End, server, *secrets, ssl=scheme == "turns", transport=transport
            )
            ends.append(made)  # at once, so that the first is closed if the second fails
        (first, one), (second, other) = ends
        pairs = ((first, second, other), (second, first, one))
        while not (one.heard.is_set() and other.heard.is_set()):
            for sender, receiver, _end in pairs:
                sender.sendto(_SENT, receiver.get_extra_info("sockname"))
            await asyncio.sleep(_AGAIN_S)
    finally:
        for transport_, _end in ends:
            transport_.close()
        await asyncio.sleep(0)  # until the refresh that ends an allocation has left
