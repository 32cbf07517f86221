"""Attacks by ICE (RFC 8445): a viewer nominates its own addresses over and over."""

from __future__ import annotations

import asyncio
from itertools import cycle
from typing import TYPE_CHECKING, Any

from aioice.ice import StunProtocol
from aioice.stun import Class, Message, Method

if TYPE_CHECKING:
    from e2e.strangers.ground import Ground


class _SecondPath:
    """Another socket of a viewer: it answers the server's checks, and drops what it is sent."""

    def __init__(self, ice: Any) -> None:
        self._ice = ice

    def request_received(
        self, check: Message, server: tuple[str, int], protocol: StunProtocol
    ) -> None:
        answer = Message(Method.BINDING, Class.RESPONSE, transaction_id=check.transaction_id)
        answer.attributes["XOR-MAPPED-ADDRESS"] = server
        answer.add_message_integrity(self._ice.local_password.encode())
        protocol.send_stun(answer, server)

    def data_received(self, _data: bytes, _component: int) -> None: ...

    def protocol_lost(self, _protocol: StunProtocol) -> None: ...


async def swaps(ground: Ground, rate_hz: float) -> None:
    """Let one viewer nominate its two paths in turn."""
    if not ground.intruders:
        return  # none was let in
    ice, pair = ground.intruders[0].ice, ground.intruders[0].pair

    def second() -> StunProtocol:
        protocol = StunProtocol(_SecondPath(ice))  # type: ignore[arg-type]  # it has what is used of one
        protocol.local_candidate = pair.local_candidate
        return protocol

    loop = asyncio.get_running_loop()
    transport, other = await loop.create_datagram_endpoint(second, ("127.0.0.1", 0))
    protocols = cycle([other, pair.protocol])
    try:
        async for _ in ground.ticks(1 / rate_hz):
            check = ice.build_request(pair, nominate=True)
            check.add_message_integrity(ice.remote_password.encode())
            next(protocols).send_stun(check, pair.remote_addr)
            ground.account["nominations"] += 1
    finally:
        transport.close()
