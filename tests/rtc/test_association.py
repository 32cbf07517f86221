"""A page that misuses its association: the work stays bounded, and only that peer ends."""

from __future__ import annotations

import asyncio
import gc
import hmac
from contextlib import asynccontextmanager
from dataclasses import dataclass
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Final, cast

import pytest
from aiortc import RTCPeerConnection, RTCSctpTransport
from aiortc.rtcdtlstransport import State
from aiortc.rtcsctptransport import (
    Chunk,
    CookieEchoChunk,
    DataChunk,
    ForwardTsnChunk,
    HeartbeatChunk,
    InboundStream,
    InitChunk,
    ReconfigChunk,
    SackChunk,
    ShutdownChunk,
    StreamAddOutgoingParam,
    StreamResetOutgoingParam,
    serialize_packet,
)
from hypothesis import given
from hypothesis import strategies as st
from tests.rtc.networks import Mode, opened_network
from tests.rtc.test_peer import Events, agree, peer_of
from tests.until import async_until

from wax.rtc import private_association

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Sequence

    from aiortc import RTCDataChannel

    from wax.rtc.network import Network
    from wax.rtc.peer import Peer

FIRST, LAST, UNORDERED = 2, 1, 4
TEXT: Final = 51
MANY: Final = 2_000


class _Together(Chunk):
    """Chunks that come in one packet."""

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

    async def take(self, chunk: Chunk) -> None:
        """Let the chunk come, alone in a packet, without the noise of a wire."""
        await self.take_packet(chunk)

    async def take_packet(self, *chunks: Chunk) -> None:
        tag = 0 if isinstance(chunks[0], InitChunk) else self.ours._local_verification_tag
        await self.ours._handle_data(serialize_packet(5000, 5000, tag, _Together(chunks)))

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


@pytest.fixture
async def link() -> AsyncIterator[Link]:
    async with opened() as made:
        yield made


@pytest.mark.parametrize("begins", [FIRST, 0])
@pytest.mark.parametrize("order", [UNORDERED, 0])
async def test_a_message_that_never_ends_ends_its_peer(link: Link, begins: int, order: int) -> None:
    """Of 2,000 fragments 65 are kept, the rest is not looked at, and the peer is closed."""
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


async def test_what_is_far_ahead_of_a_missing_chunk_is_not_taken_yet(
    link: Link, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Behind a gap no more than 256 are noted; once it is closed, everything goes on."""
    missing = link.next_tsn()
    for number in range(1, 1000):
        await link.take(link.data(missing + number, flags=FIRST | LAST | UNORDERED))
    assert len(link.ours._sack_misordered) == 256
    sent = await _sent(link, monkeypatch)
    await link.take(link.data(missing + 1000, flags=FIRST | LAST | UNORDERED))
    await async_until(lambda: [type(one) for one in sent] == [SackChunk])
    await link.take(link.data(missing, flags=FIRST | LAST | UNORDERED))
    assert link.ours._last_received_tsn == (missing + 256) % 2**32
    await link.take(link.data(missing + 257, flags=FIRST | LAST | UNORDERED))
    assert link.ours._last_received_tsn == (missing + 257) % 2**32
    assert link.peer.is_alive


@pytest.mark.parametrize(("length", "datagrams"), [(10, 1), (1150, 2)])
async def test_what_is_to_be_acknowledged_leaves_with_data(
    link: Link, length: int, datagrams: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In one datagram where both fit into it, and not once more after that."""
    sent: list[bytes] = []
    send = link.ours.transport._send_data

    async def kept(data: bytes) -> None:
        sent.append(data)
        await send(data)

    assert await link.answers("before it")
    await asyncio.sleep(0.3)  # until the last acknowledgement has left
    monkeypatch.setattr(link.ours.transport, "_send_data", kept)
    assert await link.answers("to be acknowledged")
    link.peer.send("state", "y" * length)
    await async_until(lambda: len(sent) == datagrams)
    kinds = [kind for one in sent for kind, _, _ in private_association._chunks(one)]
    assert kinds == [SackChunk.type, DataChunk.type]
    await asyncio.sleep(0.3)
    assert len(sent) == datagrams


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
    await async_until(lambda: link.ours._local_tsn == (first + 5) % 2**32)
    sack = SackChunk()
    sack.cumulative_tsn, sack.advertised_rwnd, sack.gaps = first, 100_000, [(2, 2), (4, 4)]
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


async def _sent(link: Link, monkeypatch: pytest.MonkeyPatch) -> list[Chunk]:
    """Return what our end sends from now on, for what comes from now on; nothing of it leaves."""
    await async_until(lambda: not link.ours._sack_needed)
    sent: list[Chunk] = []

    async def kept(chunk: Chunk) -> None:
        sent.append(chunk)

    monkeypatch.setattr(link.ours, "_send_chunk", kept)
    return sent


def _reset(*streams: int, number: int = 7) -> ReconfigChunk:
    chunk = ReconfigChunk()
    request = StreamResetOutgoingParam(number, 0, 0, list(streams))
    chunk.params = [(13, bytes(request))] * 40
    return chunk


def _adding() -> ReconfigChunk:
    chunk = ReconfigChunk()
    chunk.params = [(17, bytes(StreamAddOutgoingParam(9, 5)))] * 40
    return chunk


def _cookie(link: Link) -> CookieEchoChunk:
    stamp = link.ours._get_timestamp().to_bytes(4)
    return CookieEchoChunk(0, stamp + hmac.new(link.ours._hmac_key, stamp, "sha1").digest())


@pytest.mark.parametrize(
    ("chunks", "answers"),
    [
        pytest.param(lambda _: [HeartbeatChunk()] * 285, 1, id="heartbeats"),
        pytest.param(lambda _: [_reset(60_000)] * 3, 1, id="resets of one stream"),
        pytest.param(lambda _: [_adding()], 0, id="streams that are added"),
        pytest.param(lambda link: [_cookie(link)] * 40, 1, id="cookies"),
        pytest.param(lambda link: [HeartbeatChunk(), _cookie(link), _reset(1)], 1, id="of all"),
        pytest.param(lambda _: [InitChunk()], 0, id="beginning again"),
        pytest.param(lambda link: [link.data(0, flags=7)] * 58, 0, id="what came before"),
    ],
)
async def test_a_packet_gets_one_answer_no_longer_than_itself(
    link: Link,
    monkeypatch: pytest.MonkeyPatch,
    chunks: Callable[[Link], list[Chunk]],
    answers: int,
) -> None:
    """However much in it wants one; and afterwards the association goes on."""
    sent = await _sent(link, monkeypatch)
    packet = chunks(link)
    await link.take_packet(*packet)
    assert len(sent) == answers
    assert sum(len(bytes(one)) for one in sent) <= sum(len(bytes(one)) for one in packet)
    monkeypatch.undo()
    assert await link.answers("it goes on")


async def test_whoever_shuts_it_down_is_gone_without_an_answer(
    link: Link, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Hundreds of SHUTDOWNs get none, nor is one sent again later."""
    sent = await _sent(link, monkeypatch)
    await link.take_packet(*[ShutdownChunk(0, bytes(4))] * 100)
    await link.take(HeartbeatChunk())
    assert await link.ends()
    assert not sent


async def test_an_acknowledgement_is_no_longer_than_what_it_is_for(
    link: Link, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With hundreds of gaps and duplicates as few are named as there came bytes."""
    missing = link.next_tsn()
    for number in range(2, 400, 2):
        await link.take(link.data(missing + number, flags=FIRST | LAST | UNORDERED))
    sent = await _sent(link, monkeypatch)
    for size, gaps in ((1, 1), (100, 25), (1000, 199)):
        duplicate = link.data(missing + 2, flags=FIRST | LAST | UNORDERED, text=bytes(size))
        await link.take_packet(*[duplicate])
        await async_until(lambda: bool(sent))
        sack = sent.pop()
        assert isinstance(sack, SackChunk)
        assert len(sack.gaps) == gaps
        assert len(bytes(sack)) <= len(bytes(duplicate))
        assert not sent


async def test_what_goes_beyond_a_packet_comes_again(link: Link) -> None:
    """Of more chunks than a page's packet has the first are taken, the others when sent again."""
    first = link.next_tsn()
    many = [link.data(first + n, flags=FIRST | LAST | UNORDERED) for n in range(58)]
    await link.take_packet(*many)
    assert link.ours._last_received_tsn == (first + 31) % 2**32
    await link.take_packet(*many[32:])
    assert link.ours._last_received_tsn == (first + 57) % 2**32


@given(st.lists(st.integers(-5, 40), max_size=60), st.sampled_from([7, 2**32 - 12, 2**31 - 9]))
def test_numbers_are_noted_as_aiortc_notes_them(numbers: list[int], start: int) -> None:
    """In any order, repeated, and around the end of the numbers."""
    ours = cast("Any", SimpleNamespace())
    theirs: Any = RTCSctpTransport.__new__(RTCSctpTransport)
    for one in (ours, theirs):
        one._last_received_tsn, one._sack_misordered, one._sack_duplicates = start, set(), []
    association = private_association.Association(ours)
    for number in numbers:
        tsn = (start + number) % 2**32
        is_known = theirs._mark_received(tsn)
        # aiortc sorts the bare numbers, so that it stops where they begin again.
        while (theirs._last_received_tsn + 1) % 2**32 in theirs._sack_misordered:
            theirs._last_received_tsn = (theirs._last_received_tsn + 1) % 2**32
            theirs._sack_misordered.discard(theirs._last_received_tsn)
        assert association.mark_received(tsn) == is_known
        assert ours._last_received_tsn == theirs._last_received_tsn
        assert ours._sack_misordered == theirs._sack_misordered


@given(st.lists(st.integers(0, 300), unique=True, max_size=60), st.sampled_from([7, 2**32 - 90]))
def test_chunks_wait_in_their_order(numbers: list[int], start: int) -> None:
    """Whatever comes first, and around the end of the numbers."""
    stream = InboundStream()
    for number in numbers:
        chunk = DataChunk()
        chunk.tsn = (start + number) % 2**32
        private_association.add_chunk(stream, chunk)
    assert [(one.tsn - start) % 2**32 for one in stream.reassembly] == sorted(numbers)


@pytest.mark.parametrize(
    ("protocol", "text"),
    [
        pytest.param(50, b"\x03" + bytes(11), id="a channel that is open"),
        pytest.param(50, b"\x03" + bytes(7) + b"\0\x01\0\0\xff", id="a name that is no text"),
        pytest.param(51, b"\xff", id="a text that is none"),
    ],
)
async def test_what_aiortc_stumbles_over_ends_its_peer_alone(
    link: Link, protocol: int, text: bytes
) -> None:
    """Nothing is thrown into the event loop, and other viewers do not notice."""
    chunk = link.data(link.next_tsn(), flags=FIRST | LAST | UNORDERED, text=text)
    chunk.protocol = protocol
    async with opened() as other:
        await link.take(chunk)
        assert await link.ends()
        assert await other.answers("still here")


async def test_streams_that_are_only_named_count(link: Link) -> None:
    """Giving up messages of thousands of streams makes none of them."""
    chunk = ForwardTsnChunk()
    chunk.cumulative_tsn = link.next_tsn()
    chunk.streams = [(number, 0) for number in range(4000)]
    await link.take(chunk)
    assert await link.ends()


@pytest.mark.parametrize("is_closed", [True, False])
async def test_what_is_sent_while_dtls_closes_is_lost_in_silence(
    link: Link, is_closed: bool
) -> None:
    """No task of aiortc ends with an error that nobody retrieves, nor is anything repeated."""
    told: list[dict[str, Any]] = []
    asyncio.get_running_loop().set_exception_handler(lambda _, context: told.append(context))
    sctp, dtls = link.ours, cast("Any", link.ours.transport)
    next(iter(sctp._data_channels.values())).send("x")
    if is_closed:
        sctp._set_state(sctp.State.CLOSED)
        dtls._state = State.CLOSED
    else:
        dtls._ssl.shutdown()
    sent = asyncio.ensure_future(sctp._transmit())
    await asyncio.wait([sent])
    await asyncio.sleep(0)
    gc.collect()
    assert sent.exception() is None
    assert told == []
    assert not is_closed or sctp._t3_handle is None
