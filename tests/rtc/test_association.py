"""A page that misuses its association: the work stays bounded, and only that peer ends."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import pytest
from aiortc import RTCPeerConnection, RTCSctpTransport, RTCSessionDescription
from aiortc.rtcsctptransport import (
    DataChunk,
    ForwardTsnChunk,
    HeartbeatChunk,
    SackChunk,
    serialize_packet,
)
from tests.rtc.networks import network, rich_meter
from tests.rtc.test_peer import Events, Noted, Pictures, Sounds

from wax.clock import SystemClock
from wax.rtc import private
from wax.rtc.peer import Peer
from wax.streams.interface import Codecs

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from aiortc import RTCDataChannel
    from aiortc.rtcsctptransport import Chunk

FIRST, LAST, UNORDERED = 2, 1, 4
TEXT: Final = 51
MANY: Final = 20_000


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

    async def take(self, chunk: Chunk) -> None:
        """Let the chunk come, without the noise of a wire."""
        await self.ours._receive_chunk(chunk)

    async def ends(self) -> bool:
        await self.events.wait("closed")
        return not self.peer.is_alive

    async def answers(self, text: str) -> bool:
        """Tell whether a message still comes through."""
        self.state.send(text)
        async with asyncio.timeout(10):
            while ("received state", text) not in self.events.seen:
                self.events.news.clear()
                await self.events.news.wait()
        return self.peer.is_alive


@asynccontextmanager
async def opened() -> AsyncIterator[Link]:
    private.install()
    events = Events()
    peer = Peer(
        network=network(),
        meter=rich_meter(),
        codecs=Codecs(audio="opus", video="vp8"),
        video=Pictures(),
        audio=Sounds(),
        congestion=Noted(),
        events=events,
        clock=SystemClock(),
        round_trip_s=lambda: 0.5,
    )
    page = RTCPeerConnection()
    page.addTransceiver("audio", direction="recvonly")
    page.addTransceiver("video", direction="recvonly")
    drive = page.createDataChannel("drive", ordered=False, maxRetransmits=0)
    state = page.createDataChannel("state")
    are_open = [asyncio.Event(), asyncio.Event()]
    for channel, is_open in zip((drive, state), are_open, strict=True):
        channel.on("open", is_open.set)
    await page.setLocalDescription(await page.createOffer())
    answer = await peer.answer(page.localDescription.sdp)
    await page.setRemoteDescription(RTCSessionDescription(answer, "answer"))
    await events.wait("ready")
    async with asyncio.timeout(10):
        await asyncio.gather(*(is_open.wait() for is_open in are_open))
    yield Link(peer, events, page, state, drive)
    await peer.close()
    await page.close()


@pytest.fixture
async def link() -> AsyncIterator[Link]:
    async with opened() as made:
        yield made


@pytest.mark.parametrize("begins", [FIRST, 0])
@pytest.mark.parametrize("order", [UNORDERED, 0])
async def test_a_message_that_never_ends_ends_its_peer(link: Link, begins: int, order: int) -> None:
    """Of 20,000 fragments 65 are kept, the rest is not looked at, and the peer is closed."""
    tsn, most = link.next_tsn(), 0
    for number in range(MANY):
        await link.take(link.data(tsn + number, flags=order | (0 if number else begins)))
        most = max(most, link.kept)
    assert most == 65
    assert await link.ends()


async def test_over_a_real_wire_only_that_peer_ends() -> None:
    """Another viewer's messages go on while the fragments come."""
    async with opened() as bad, opened() as good:
        tsn = bad.next_tsn()
        for number in range(200):
            await bad.theirs._send_chunk(bad.data(tsn + number, flags=FIRST if not number else 0))
        assert await bad.ends()
        assert await good.answers("still here")


async def test_few_fragments_that_are_large_end_it_too(link: Link) -> None:
    """More than 64 KiB do not wait for the rest of a message."""
    tsn, size = link.next_tsn(), 1150
    for number in range(64):
        text = bytes(size)
        await link.take(link.data(tsn + number, flags=0 if number else FIRST, text=text))
    assert link.kept == 65_536 // size + 1
    assert await link.ends()


async def test_messages_behind_one_that_never_comes_end_it(link: Link) -> None:
    """Whole messages whose turn never comes are not kept without bound either."""
    tsn = link.next_tsn()
    for number in range(MANY):
        await link.take(link.data(tsn + number, flags=FIRST | LAST, sequence=1000))
    assert link.kept == 64 + 256 + 1
    assert await link.ends()


@pytest.mark.parametrize("channel", ["state", "drive"])
async def test_the_longest_message_arrives(link: Link, channel: str) -> None:
    """64 KiB at once are received, and the page is told not to send more."""
    assert "a=max-message-size:65536\r\n" in link.peer._pc.localDescription.sdp
    text = "x" * 65_536
    getattr(link, channel).send(text)
    assert await link.events.wait(f"received {channel}") == text
    assert await link.answers("after it")


async def test_what_is_far_ahead_of_a_missing_chunk_is_not_taken_yet(link: Link) -> None:
    """Behind a gap no more than 256 are noted; once it is closed, everything goes on."""
    missing = link.next_tsn()
    for number in range(1, 1000):
        await link.take(link.data(missing + number, flags=FIRST | LAST | UNORDERED))
    assert len(link.ours._sack_misordered) == 256
    assert link.ours._sack_needed
    await link.take(link.data(missing, flags=FIRST | LAST | UNORDERED))
    assert link.ours._last_received_tsn == (missing + 256) % 2**32
    await link.take(link.data(missing + 257, flags=FIRST | LAST | UNORDERED))
    assert link.ours._last_received_tsn == (missing + 257) % 2**32
    assert link.peer.is_alive


async def test_an_acknowledgement_of_what_was_not_sent_ends_it(link: Link) -> None:
    """Gaps of millions of numbers are not gone through one by one."""
    sack = SackChunk()
    sack.cumulative_tsn = (link.ours._local_tsn - 1) % 2**32
    sack.advertised_rwnd = 100_000
    sack.gaps = [(2, 65_535)] * 4000
    await link.take(sack)
    assert await link.ends()


async def test_an_acknowledgement_of_what_comes_later_ends_it(link: Link) -> None:
    """Nobody can have received what has no number yet."""
    sack = SackChunk()
    sack.cumulative_tsn = (link.ours._local_tsn + 5) % 2**32
    sack.advertised_rwnd = 100_000
    await link.take(sack)
    assert await link.ends()


async def test_gaps_in_what_was_sent_are_none(link: Link) -> None:
    """A page that has lost some of ours may say so."""
    first = (link.ours._local_tsn - 1) % 2**32
    for _ in range(4):
        link.peer.send("state", "y")
    await asyncio.sleep(0)
    await asyncio.sleep(0)
    sack = SackChunk()
    sack.cumulative_tsn, sack.advertised_rwnd, sack.gaps = first, 100_000, [(2, 2), (4, 4)]
    assert link.ours._local_tsn == (first + 5) % 2**32
    await link.take(sack)
    assert link.peer.is_alive
    assert await link.answers("it goes on")


async def test_a_parameter_of_no_length_is_refused(link: Link) -> None:
    """A packet whose parameters would be read for ever is dropped, and the peer lives."""
    chunk = HeartbeatChunk()
    chunk.params = [(1, b"")]
    tag = link.ours._local_verification_tag
    whole = serialize_packet(5000, 5000, tag, chunk)
    assert whole[-4:] == b"\0\1\0\4"
    chunk.params = []
    short = type("Short", (HeartbeatChunk,), {"body": b"\0\1\0\0"})()
    await link.ours._handle_data(serialize_packet(5000, 5000, tag, short))
    await link.ours._handle_data(whole)
    assert await link.answers("it goes on")


async def test_a_page_with_more_channels_than_it_needs_ends(link: Link) -> None:
    """Eight may be open at once, not nine."""
    for number in range(6):
        link.page.createDataChannel(f"more {number}")
    assert await link.answers("eight")
    link.page.createDataChannel("one too many")
    assert await link.ends()


async def test_streams_that_are_only_named_count(link: Link) -> None:
    """Giving up messages of thousands of streams makes none of them."""
    chunk = ForwardTsnChunk()
    chunk.cumulative_tsn = link.next_tsn()
    chunk.streams = [(number, 0) for number in range(4000)]
    await link.take(chunk)
    assert await link.ends()
