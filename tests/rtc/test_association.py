"""A page that abuses its SCTP association causes bounded work, and only its own peer ends."""

from __future__ import annotations

import asyncio
import gc
import hmac
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Final, cast

import pytest
from aiortc import RTCSctpTransport
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
from tests.rtc.real_link import FIRST, LAST, UNORDERED, Link, opened
from tests.until import async_until

from wax.rtc import private_association

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable


MANY: Final = 2_000


@pytest.fixture
async def link() -> AsyncIterator[Link]:
    async with opened() as made:
        yield made


@pytest.mark.parametrize("begins", [FIRST, 0])
@pytest.mark.parametrize("order", [UNORDERED, 0])
async def test_endless_fragments_end_their_peer(link: Link, begins: int, order: int) -> None:
    """Of 2,000 fragments 65 are kept, the rest is ignored, and the peer is closed."""
    tsn, most = link.next_tsn(), 0
    for number in range(MANY):
        await link.receive(link.data(tsn + number, flags=order | (0 if number else begins)))
        most = max(most, link.kept)
    assert most == 65
    assert await link.ends()


async def test_over_a_real_connection_only_that_peer_ends() -> None:
    """Another viewer's messages arrive while the fragments come."""
    async with opened() as bad, opened() as good:
        tsn = bad.next_tsn()
        for number in range(200):
            await bad.theirs._send_chunk(bad.data(tsn + number, flags=FIRST if not number else 0))
        assert await bad.ends()
        assert await good.answers("still here")


async def test_large_fragments_end_their_peer(link: Link) -> None:
    """A peer ends when more than 64 KiB wait for the rest of a message."""
    tsn, size = link.next_tsn(), 1150
    for number in range(64):
        text = bytes(size)
        await link.receive(link.data(tsn + number, flags=0 if number else FIRST, text=text))
    assert link.kept == 65_536 // size + 1
    assert await link.ends()


async def test_messages_waiting_for_a_missing_one_end_their_peer(link: Link) -> None:
    """Whole messages that wait behind a missing one are not kept without bound either."""
    tsn = link.next_tsn()
    for number in range(MANY):
        await link.receive(link.data(tsn + number, flags=FIRST | LAST, sequence=1000))
    assert link.kept == 64 + 256 + 1
    assert await link.ends()


async def test_messages_that_one_completes_arrive_in_order(link: Link) -> None:
    """Nothing is lost or overtaken while others go on between them."""
    first = link.next_tsn()
    assert link.state.id is not None
    turn = link.ours._inbound_streams[link.state.id].sequence_number
    for number in [*range(1, 200), 0]:
        text = b"%d" % number
        chunk = link.data(first + number, flags=FIRST | LAST, text=text, sequence=turn + number)
        await link.theirs._send_chunk(chunk)
    texts = [("received state", str(number)) for number in range(200)]
    await async_until(lambda: [one for one in link.events.seen if one in texts] == texts)


@pytest.mark.parametrize("channel", ["state", "drive"])
async def test_the_longest_message_arrives(link: Link, channel: str) -> None:
    """64 KiB at once are received, and the page is told not to send more."""
    assert "a=max-message-size:65536\r\n" in link.peer._pc.localDescription.sdp
    text = "x" * 65_536
    getattr(link, channel).send(text)
    assert await link.events.wait(f"received {channel}") == text
    assert await link.answers("after it")


async def test_chunks_far_ahead_of_a_gap_are_not_accepted_yet(
    link: Link, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At most 256 chunks are accepted behind a gap; once it is closed, all others follow."""
    missing = link.next_tsn()
    for number in range(1, 1000):
        await link.receive(link.data(missing + number, flags=FIRST | LAST | UNORDERED))
    assert len(link.ours._sack_misordered) == 256
    sent = await _sent(link, monkeypatch)
    await link.receive(link.data(missing + 1000, flags=FIRST | LAST | UNORDERED))
    await async_until(lambda: [type(one) for one in sent] == [SackChunk])
    await link.receive(link.data(missing, flags=FIRST | LAST | UNORDERED))
    assert link.ours._last_received_tsn == (missing + 256) % 2**32
    await link.receive(link.data(missing + 257, flags=FIRST | LAST | UNORDERED))
    assert link.ours._last_received_tsn == (missing + 257) % 2**32
    assert link.peer.is_alive


@pytest.mark.parametrize(("length", "datagrams"), [(10, 1), (1150, 2)])
async def test_acknowledgements_are_bundled_with_data(
    link: Link, length: int, datagrams: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """DATA carries a waiting acknowledgement, once, if both fit in a datagram."""
    sent: list[bytes] = []
    send = link.ours.transport._send_data

    async def kept(data: bytes) -> None:
        sent.append(data)
        await send(data)

    assert await link.answers("before it")
    await asyncio.sleep(0.3)  # lets the last acknowledgement leave
    monkeypatch.setattr(link.ours.transport, "_send_data", kept)
    assert await link.answers("to be acknowledged")
    link.peer.send("state", "y" * length)
    await async_until(lambda: len(sent) == datagrams)
    kinds = [kind for one in sent for kind, _, _ in private_association._chunks(one)]
    assert kinds == [SackChunk.type, DataChunk.type]
    await asyncio.sleep(0.3)
    assert len(sent) == datagrams


async def test_gaps_beyond_what_was_sent_end_the_peer(link: Link) -> None:
    """Gaps of millions of TSNs are not iterated over."""
    sack = SackChunk()
    sack.cumulative_tsn = (link.ours._local_tsn - 1) % 2**32
    sack.advertised_rwnd = 100_000
    sack.gaps = [(2, 65_535)] * 4000
    await link.receive(sack)
    assert await link.ends()


async def test_an_acknowledgement_of_unsent_tsns_ends_the_peer(link: Link) -> None:
    """An acknowledgement of TSNs not sent yet ends the peer."""
    sack = SackChunk()
    sack.cumulative_tsn = (link.ours._local_tsn + 5) % 2**32
    sack.advertised_rwnd = 100_000
    await link.receive(sack)
    assert await link.ends()


async def test_gaps_in_what_was_sent_are_accepted(link: Link) -> None:
    """A page that has lost some of our chunks may report the gaps."""
    first = (link.ours._local_tsn - 1) % 2**32
    for _ in range(4):
        link.peer.send("state", "y")
    await async_until(lambda: link.ours._local_tsn == (first + 5) % 2**32)
    sack = SackChunk()
    sack.cumulative_tsn, sack.advertised_rwnd, sack.gaps = first, 100_000, [(2, 2), (4, 4)]
    await link.receive(sack)
    assert link.peer.is_alive
    assert await link.answers("it goes on")


async def test_a_parameter_of_no_length_is_refused(link: Link) -> None:
    """A packet whose parsing would never end is dropped, and the peer lives."""
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


async def test_too_many_channels_end_the_peer(link: Link) -> None:
    """A page may have eight channels, not nine."""
    for number in range(6):
        link.page.createDataChannel(f"more {number}")
    assert await link.answers("eight")
    link.page.createDataChannel("one too many")
    assert await link.ends()


async def _sent(link: Link, monkeypatch: pytest.MonkeyPatch) -> list[Chunk]:
    """Return a list that collects what our end sends in future; nothing of it leaves."""
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
    """A packet with many requests gets one short answer, and the association continues."""
    sent = await _sent(link, monkeypatch)
    packet = chunks(link)
    await link.receive_packet(*packet)
    assert len(sent) == answers
    assert sum(len(bytes(one)) for one in sent) <= sum(len(bytes(one)) for one in packet)
    monkeypatch.undo()
    assert await link.answers("it goes on")


async def test_a_shutdown_ends_without_an_answer(
    link: Link, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Hundreds of SHUTDOWNs get no answer, neither at once nor later."""
    sent = await _sent(link, monkeypatch)
    await link.receive_packet(*[ShutdownChunk(0, bytes(4))] * 100)
    await link.receive(HeartbeatChunk())
    assert await link.ends()
    assert not sent


async def test_a_sack_is_no_longer_than_what_it_acknowledges(
    link: Link, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of hundreds of gaps, a SACK lists only as many as the size of what it acknowledges allows."""
    missing = link.next_tsn()
    for number in range(2, 400, 2):
        await link.receive(link.data(missing + number, flags=FIRST | LAST | UNORDERED))
    sent = await _sent(link, monkeypatch)
    for size, gaps in ((1, 1), (100, 25), (1000, 199)):
        duplicate = link.data(missing + 2, flags=FIRST | LAST | UNORDERED, text=bytes(size))
        await link.receive_packet(*[duplicate])
        await async_until(lambda: bool(sent))
        sack = sent.pop()
        assert isinstance(sack, SackChunk)
        assert len(sack.gaps) == gaps
        assert len(bytes(sack)) <= len(bytes(duplicate))
        assert not sent


async def test_excess_chunks_are_handled_when_retransmitted(link: Link) -> None:
    """Of too many chunks in one packet the first are handled, and the others when retransmitted."""
    first = link.next_tsn()
    many = [link.data(first + n, flags=FIRST | LAST | UNORDERED) for n in range(58)]
    await link.receive_packet(*many)
    assert link.ours._last_received_tsn == (first + 31) % 2**32
    await link.receive_packet(*many[32:])
    assert link.ours._last_received_tsn == (first + 57) % 2**32


@given(st.lists(st.integers(-5, 40), max_size=60), st.sampled_from([7, 2**32 - 12, 2**31 - 9]))
def test_tsns_are_recorded_as_by_aiortc(numbers: list[int], start: int) -> None:
    """TSNs are recorded as aiortc does in any order, repeated, and across the wrap."""
    ours = cast("Any", SimpleNamespace())
    theirs: Any = RTCSctpTransport.__new__(RTCSctpTransport)
    for one in (ours, theirs):
        one._last_received_tsn, one._sack_misordered, one._sack_duplicates = start, set(), []
    association = private_association.Association(ours)
    for number in numbers:
        tsn = (start + number) % 2**32
        is_known = theirs._mark_received(tsn)
        # aiortc sorts the wrapped TSNs, so it stops where they wrap.
        while (theirs._last_received_tsn + 1) % 2**32 in theirs._sack_misordered:
            theirs._last_received_tsn = (theirs._last_received_tsn + 1) % 2**32
            theirs._sack_misordered.discard(theirs._last_received_tsn)
        assert association.mark_received(tsn) == is_known
        assert ours._last_received_tsn == theirs._last_received_tsn
        assert ours._sack_misordered == theirs._sack_misordered


@given(st.lists(st.integers(0, 300), unique=True, max_size=60), st.sampled_from([7, 2**32 - 90]))
def test_chunks_are_kept_in_tsn_order(numbers: list[int], start: int) -> None:
    """Chunks are kept in TSN order, whichever comes first, and across the wrap."""
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
async def test_an_error_of_aiortc_ends_only_its_peer(
    link: Link, protocol: int, text: bytes
) -> None:
    """An error of aiortc's reaches neither the event loop nor other viewers."""
    chunk = link.data(link.next_tsn(), flags=FIRST | LAST | UNORDERED, text=text)
    chunk.protocol = protocol
    async with opened() as other:
        await link.receive(chunk)
        assert await link.ends()
        assert await other.answers("still here")


async def test_forward_tsn_creates_no_streams(link: Link) -> None:
    """Abandoning messages of thousands of streams creates none of these."""
    chunk = ForwardTsnChunk()
    chunk.cumulative_tsn = link.next_tsn()
    chunk.streams = [(number, 0) for number in range(4000)]
    await link.receive(chunk)
    assert await link.ends()


@pytest.mark.parametrize("is_closed", [True, False])
async def test_sending_while_dtls_closes_fails_silently(link: Link, is_closed: bool) -> None:
    """While DTLS closes, no task's error goes unretrieved, and nothing is retransmitted."""
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
