"""A peer of ours joined to a page, whose chunks a test can make and receive by itself."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from aiortc import RTCPeerConnection, RTCSctpTransport
from aiortc.rtcsctptransport import (
    Chunk,
    DataChunk,
    InitChunk,
    serialize_packet,
)
from tests.rtc.networks import Mode, opened_network
from tests.rtc.real_peer import Events, agree, peer_of

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Sequence

    from aiortc import RTCDataChannel

    from wax.rtc.network import Network
    from wax.rtc.peer import Peer

FIRST, LAST, UNORDERED = 2, 1, 4
TEXT: Final = 51


class _Together(Chunk):
    """Chunks that arrive in one packet."""

    def __init__(self, chunks: Sequence[Chunk]) -> None:
        self._chunks = chunks

    def __bytes__(self) -> bytes:
        return b"".join(map(bytes, self._chunks))


@dataclass
class Link:
    """A peer of ours and the page's side of it, both real."""

    peer: Peer
    events: Events
    page: RTCPeerConnection
    state: RTCDataChannel
    drive: RTCDataChannel

    @property
    def ours(self) -> RTCSctpTransport:
        assert self.peer._pc.sctp is not None
        return self.peer._pc.sctp

    @property
    def theirs(self) -> RTCSctpTransport:
        assert self.page.sctp is not None
        return self.page.sctp

    def next_tsn(self) -> int:
        assert self.ours._last_received_tsn is not None
        return (self.ours._last_received_tsn + 1) % 2**32

    def data(self, tsn: int, *, flags: int, text: bytes = b"x", sequence: int = 0) -> DataChunk:
        chunk = DataChunk(flags=flags)
        chunk.tsn, chunk.stream_id, chunk.stream_seq = tsn % 2**32, self.state.id, sequence
        chunk.protocol, chunk.user_data = TEXT, text
        return chunk

    @property
    def kept(self) -> int:
        return sum(len(one.reassembly) for one in self.ours._inbound_streams.values())

    async def receive(self, chunk: Chunk) -> None:
        """Receive the chunk, alone in a packet, without a network."""
        await self.receive_packet(chunk)

    async def receive_packet(self, *chunks: Chunk) -> None:
        tag = 0 if isinstance(chunks[0], InitChunk) else self.ours._local_verification_tag
        await self.ours._handle_data(serialize_packet(5000, 5000, tag, _Together(chunks)))

    async def ends(self) -> bool:
        await self.events.wait("closed")
        return not self.peer.is_alive

    async def answers(self, text: str) -> bool:
        """Return whether a message still arrives."""
        self.state.send(text)
        async with asyncio.timeout(10):
            while ("received state", text) not in self.events.seen:
                self.events.news.clear()
                await self.events.news.wait()
        return self.peer.is_alive


@asynccontextmanager
async def opened(mode: Mode = "full-ice") -> AsyncIterator[Link]:
    async with opened_network(mode) as network, _joined(network) as link:
        yield link


@asynccontextmanager
async def _joined(network: Network) -> AsyncIterator[Link]:
    events = Events()
    peer = peer_of(network, events)
    page = RTCPeerConnection()
    page.addTransceiver("audio", direction="recvonly")
    page.addTransceiver("video", direction="recvonly")
    drive = page.createDataChannel("drive", ordered=False, maxRetransmits=0)
    state = page.createDataChannel("state")
    are_open = [asyncio.Event(), asyncio.Event()]
    for channel, is_open in zip((drive, state), are_open, strict=True):
        channel.on("open", is_open.set)
    await agree(peer, page)
    await events.wait("ready")
    async with asyncio.timeout(10):
        await asyncio.gather(*(is_open.wait() for is_open in are_open))
    yield Link(peer, events, page, state, drive)
    await peer.close()
    await page.close()
