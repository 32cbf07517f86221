"""The public addresses that viewers are offered, as they change."""

from __future__ import annotations

import asyncio
import socket
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, cast

from aioice.stun import Class, Message, Method, parse_message
from tests.free_port import free_port
from tests.until import async_until

from wax.rtc.local_addresses import is_ours
from wax.rtc.public_addresses import PublicAddresses
from wax.rtc.stun_query import StunAnswer, StunError

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    import pytest


class StunServer(asyncio.DatagramProtocol):
    """Answers with an address of the test's choice."""

    seen = "203.0.113.7"

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self.transport = cast("asyncio.DatagramTransport", transport)

    def datagram_received(self, data: bytes, address: tuple[str, int]) -> None:
        answer = Message(Method.BINDING, Class.RESPONSE, parse_message(data).transaction_id)
        answer.attributes["XOR-MAPPED-ADDRESS"] = (self.seen, address[1])
        self.transport.sendto(bytes(answer), address)


@asynccontextmanager
async def stun_server() -> AsyncIterator[tuple[StunServer, str]]:
    transport, server = await asyncio.get_running_loop().create_datagram_endpoint(
        StunServer, local_addr=("127.0.0.1", 0)
    )
    try:
        yield server, f"stun:127.0.0.1:{transport.get_extra_info('sockname')[1]}"
    finally:
        transport.close()
        await asyncio.sleep(0)


async def test_the_address_seen_by_a_stun_server_is_offered_too() -> None:
    """The address that the first answering server sees is offered too, and follows changes."""
    async with stun_server() as (server, url):
        nobody = f"stun:127.0.0.1:{free_port(socket.SOCK_DGRAM)}"
        addresses = PublicAddresses(["198.51.100.1"], [nobody, url])
        assert addresses.now() == ["198.51.100.1"]
        assert await addresses.refresh()
        assert addresses.now() == ["198.51.100.1", "203.0.113.7"]
        server.seen = "198.51.100.1"
        assert await addresses.refresh()
        assert addresses.now() == ["198.51.100.1"]


async def test_a_silent_server_removes_nothing() -> None:
    """While servers are silent, the last address seen is still offered."""
    answers = iter([StunAnswer("203.0.113.7", "127.0.0.1")])

    def ask(server: str) -> StunAnswer:
        assert server == "stun.example:3478"
        try:
            return next(answers)
        except StopIteration:
            raise StunError("does not answer") from None

    addresses = PublicAddresses([], ["stun:stun.example:3478"], ask)
    assert await addresses.refresh()
    assert not await addresses.refresh()
    assert addresses.now() == ["203.0.113.7"]


async def test_in_a_new_network_the_old_public_address_expires(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The public address expires with its local address, and is asked for within seconds."""
    monkeypatch.setattr("wax.rtc.public_addresses._CHECK_S", 0.01)
    home, cafe = StunAnswer("203.0.113.7", "192.168.0.5"), StunAnswer("198.51.100.9", "10.0.0.5")
    here = home

    def ask(_server: str) -> StunAnswer:
        return here

    addresses = PublicAddresses([], ["stun:stun.example"], ask, lambda own: own == here.own)
    running = asyncio.create_task(addresses.run())
    await async_until(lambda: addresses.now() == ["203.0.113.7"])
    here = cafe
    assert addresses.now() == []
    await async_until(lambda: addresses.now() == ["198.51.100.9"])
    running.cancel()
    await asyncio.wait([running])


async def test_in_a_new_network_without_an_answer_nothing_is_offered() -> None:
    """If no server answers in the new network, the old network's address is not offered."""
    answers = iter([StunAnswer("203.0.113.7", "192.0.2.1")])

    def ask(_server: str) -> StunAnswer:
        try:
            return next(answers)
        except StopIteration:
            raise StunError("does not answer") from None

    addresses = PublicAddresses([], ["stun:stun.example"], ask, is_ours)
    assert await addresses.refresh()
    assert not await addresses.refresh()
    assert addresses.now() == []


async def test_without_a_server_nobody_is_asked() -> None:
    """Without servers it asks nobody and waits until cancelled."""

    def ask(server: str) -> StunAnswer:
        raise AssertionError(server)

    running = asyncio.create_task(PublicAddresses([], [], ask).run())
    await asyncio.sleep(0.01)
    assert not running.done()
    running.cancel()
    await asyncio.wait([running])
