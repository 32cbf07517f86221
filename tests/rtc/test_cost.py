"""A browser's datagram costs the event loop no more than its bytes warrant."""

from __future__ import annotations

import asyncio
import re
from itertools import pairwise
from pathlib import Path
from struct import pack
from typing import TYPE_CHECKING, Final

import pytest
from aiortc.rtcsctptransport import ForwardTsnChunk, HeartbeatChunk, SackChunk
from tests.fuzz.target import at_once
from tests.fuzz.targets.network import _PICTURE, _Page
from tests.rtc.networks import opened_network
from tests.rtc.real_link import FIRST, LAST, UNORDERED, Link, opened
from tests.rtc.real_peer import Events, Pictures, peer_of
from tests.rtc.steps import counted
from tests.until import async_until

from wax.rtc import private
from wax.rtc.signalling import clean_offer
from wax.streams.interface import CameraLane

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

    from aiortc import RTCCertificate
    from aiortc.rtcsctptransport import Chunk

    from wax.rtc.peer import Peer

OFFERS: Final = Path(__file__).parent / "offers"
IN_FLIGHT: Final = 2500
"""Five seconds of the largest rendition."""
MOST: Final = 250_000
"""Instructions per datagram, little more than a millisecond; 28 feedbacks in one took millions, and
most of these take a tenth."""


def _rtcp(kind: int, count: int, body: bytes) -> bytes:
    return pack("!BBH", 0x80 | count, kind, len(body) // 4) + body


def _feedback(first: int, packets: int, chunks: list[int], times: bytes = b"") -> bytes:
    body = pack("!LLHHL", 1, 2, first & 0xFFFF, packets, 0)
    body += b"".join(pack("!H", one) for one in chunks) + times
    return _rtcp(205, 15, body + bytes(-len(body) % 4))


def _filled(one: bytes) -> bytes:
    return one * (1200 // len(one))


def _nack(*asked: tuple[int, int]) -> bytes:
    return _rtcp(205, 1, pack("!LL", 1, _PICTURE) + b"".join(pack("!HH", *one) for one in asked))


def _compound(kind: int, count: int, size: int) -> bytes:
    return _filled(_rtcp(kind, count, pack("!LL", 1, _PICTURE)[: min(size, 8)] + bytes(size - 8)))


DATAGRAMS: Final[dict[str, Callable[[int], bytes]]] = {
    "65,535 packets that did not arrive": lambda at: _filled(_feedback(at, 65_535, [0x1FFF] * 9)),
    "all that is in flight": lambda at: _filled(_feedback(at, IN_FLIGHT, [IN_FLIGHT] * 2)),
    "lost but the last": lambda at: _feedback(at, IN_FLIGHT, [IN_FLIGHT - 1, 0x2001], b"\1"),
    "one arrival each": lambda at: b"".join(
        _feedback(at + n, 1, [0x2001], b"\1") for n in range(48)
    ),
    "1100 arrivals": lambda at: _feedback(at, 1100, [0x2000 | 1100], bytes(1100)),
    "1100 that jump": lambda at: _feedback(at, 550, [0x4000 | 550], b"\x7f\xff\x80\x00" * 275),
    "vectors of nothing": lambda at: _feedback(at, 8120, [0x8000] * 580),
    "runs without times": lambda at: _feedback(at, 65_535, [0x3FFF] * 580),
    "numbers that were never sent": lambda _: _nack(*((17 * n, 0xFFFF) for n in range(296))),
    "requests of one number each": lambda _: _filled(_nack((5, 0xFFFF))),
    "empty reports": lambda _: _filled(_rtcp(201, 0, pack("!L", 1))),
    "31 reports on one stream": lambda _: _rtcp(
        201, 31, pack("!L", 1) + pack("!LLLLLL", _PICTURE, 0x10000000, 5, 6, 7, 8) * 31
    ),
    "requests for keyframes": lambda _: _compound(206, 1, 8),
    "REMB": lambda _: _compound(206, 15, 16),
    "names": lambda _: _compound(202, 1, 8),
    "farewells": lambda _: _compound(203, 1, 8),
    "extended reports": lambda _: _compound(207, 0, 8),
}


@pytest.mark.parametrize("name", DATAGRAMS)
def test_rtcp_costs_what_its_bytes_cost(name: str) -> None:
    """RTCP has a bounded cost with five seconds in flight, at first and when repeated."""
    private.install()
    page = _Page()
    first = page.tap._transmissions._next
    for number in range(IN_FLIGHT):
        page.clock.time_s += 0.0015
        page.tap.number_packet(1200, page.clock.time_s, kind="video", train=number // 5)
        page.tap.count_media(1200, page.clock.time_s, has_feedback=True)
    datagram = DATAGRAMS[name](first)
    assert len(datagram) <= 1200
    for _ in range(5):
        page.clock.time_s += 0.001
        with counted() as steps:
            at_once(page.transport._handle_rtcp_data(datagram))
        assert steps.count < MOST


def _data(link: Link, place: int, *, flags: int = FIRST | LAST | UNORDERED, turn: int = 0) -> Chunk:
    return link.data(link.next_tsn() + place, flags=flags, sequence=turn)


def _forward(link: Link) -> Chunk:
    chunk = ForwardTsnChunk()
    chunk.cumulative_tsn = link.next_tsn()
    assert link.state.id is not None
    chunk.streams = [(link.state.id, 0)] * 290
    return chunk


def _sack(link: Link) -> Chunk:
    chunk = SackChunk()
    chunk.cumulative_tsn = (link.ours._local_tsn - 1) % 2**32
    chunk.gaps = [(0, 0)] * 290
    return chunk


PACKETS: Final[dict[str, Callable[[Link], list[Chunk]]]] = {
    "heartbeats": lambda _: [HeartbeatChunk()] * 285,
    "messages of one byte": lambda link: [_data(link, n) for n in range(58)],
    "behind one that is missing": lambda link: [_data(link, 240 - n) for n in range(58)],
    "fragments": lambda link: [_data(link, 2 * n + 2, flags=UNORDERED) for n in range(58)],
    "out of their turn": lambda link: [
        _data(link, 240 - n, flags=FIRST | LAST, turn=1000) for n in range(58)
    ],
    "what came before": lambda link: [_data(link, -1)] * 58,
    "messages given up": lambda link: [_forward(link)],
    "gaps": lambda link: [_sack(link)],
}


@pytest.fixture
async def link() -> AsyncIterator[Link]:
    async with opened() as made:
        yield made


@pytest.mark.parametrize("name", PACKETS)
async def test_sctp_costs_what_its_bytes_cost(link: Link, name: str) -> None:
    """SCTP has a bounded cost with 200 chunks waiting for a missing one, some out of turn."""
    for number in range(1, 201):
        chunk = _data(link, number, flags=FIRST | LAST, turn=1000)
        await link.receive(chunk)
    packet = PACKETS[name](link)
    for _ in range(3):
        with counted() as steps:
            await link.receive_packet(*packet)
        assert steps.count < MOST


async def test_answering_five_pictures_takes_no_long_pass() -> None:
    """The work of an offer is spread over passes of the event loop that others share."""
    offer = (OFFERS / "chromium.sdp").read_text().replace("\n", "\r\n")
    head, sound, picture, rest = re.split(r"(?=m=)", offer)
    further = [picture.replace("a=mid:1", f"a=mid:{n}") for n in range(3, 7)]
    offer = "".join([head.replace("0 1 2", "0 1 2 3 4 5 6"), sound, picture, rest, *further])
    async with opened_network() as network:
        cameras = [CameraLane(Pictures(), "vp8") for _ in further]
        peer = peer_of(network, Events(), cameras=cameras)
        cleaned = clean_offer(offer, None, {"opus", "vp8"})
        answering = asyncio.create_task(peer.answer(cleaned))
        longest, made = 0, [0]
        while not answering.done():
            made.append(len(peer._pc.getTransceivers()))
            with counted() as steps:
                await asyncio.sleep(0)
            longest = max(longest, steps.count)
        assert (await answering).count("m=video") == 5
        await peer.close()
    assert longest < MOST / 2
    assert all(after - before <= 1 for before, after in pairwise(made))


async def test_peers_share_a_certificate_for_a_day(monkeypatch: pytest.MonkeyPatch) -> None:
    """Making one takes a millisecond, so no offer makes one; the next day's is made in a thread."""

    def certificates(peer: Peer) -> list[RTCCertificate]:
        found: list[RTCCertificate] = getattr(peer._pc, private._CERTIFICATES)
        return found

    monkeypatch.setattr("wax.rtc.network._CERTIFICATE_S", 0.0)
    async with opened_network() as network:
        first, second = (peer_of(network, Events()) for _ in range(2))
        assert certificates(first) == certificates(second) == [network._certificate]
        renewing = asyncio.create_task(network.run())
        await async_until(lambda: certificates(first) != [network._certificate])
        renewing.cancel()
        third = peer_of(network, Events())
        assert certificates(third) == [network._certificate]
        for peer in (first, second, third):
            await peer.close()
