"""Datagrams that anybody can send to a peer's port without being admitted."""

from __future__ import annotations

import asyncio
import socket
from typing import TYPE_CHECKING, Any, Final, cast

import aioice.stun
import pytest
from aiortc.rtp import RtcpPsfbPacket, RtcpReceiverInfo, RtcpRrPacket, pack_remb_fci
from aiortc.sdp import SessionDescription
from tests.rtc.real_link import Link, opened

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from tests.rtc.real_peer import Noted

_HEADER: Final = b"\x00\x01" + (8).to_bytes(2) + aioice.stun.COOKIE.to_bytes(4) + b"0123456789ab"


@pytest.fixture
async def link() -> AsyncIterator[Link]:
    async with opened() as made:
        yield made


def _addresses(link: Link) -> list[tuple[str, int]]:
    offered = SessionDescription.parse(link.page.remoteDescription.sdp)
    return [(one.ip, one.port) for one in offered.media[0].ice_candidates if ":" not in one.ip]


DATAGRAMS = {
    "empty": b"",
    "one byte": b"\x80",
    "no DTLS": b"\x16\xfe\xfd" + b"\xff" * 40,
    "a priority of one byte": _HEADER + b"\x00\x24\x00\x01a...",
    "a tie breaker of three bytes": _HEADER + b"\x80\x2a\x00\x03abc.",
    "no address": _HEADER + b"\x00\x20\x00\x00\x00\x24\x00\x00",
}


async def test_a_strangers_datagram_ends_nobody(link: Link) -> None:
    """After a stranger's datagram, messages still arrive and the event loop sees no error."""
    thrown: list[dict[str, Any]] = []
    asyncio.get_running_loop().set_exception_handler(lambda _loop, what: thrown.append(what))
    for name, datagram in DATAGRAMS.items():
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
            for address in _addresses(link):
                stranger.sendto(datagram, address)
        await asyncio.sleep(0.05)
        assert await link.answers(name)
        assert not thrown, name


async def test_a_truncated_report_is_ignored(link: Link) -> None:
    """A REMB that announces more streams than it names does not end its own sender's peer."""
    cut = RtcpPsfbPacket(fmt=15, ssrc=1, media_ssrc=0, fci=pack_remb_fci(10**6, [1, 2])[:-4])
    sound = link.peer._pc.getSenders()[0]
    await sound.transport._handle_rtcp_data(bytes(cut))
    assert await link.answers("still here")


async def test_a_page_has_a_bounded_number_of_sources(link: Link) -> None:
    """SSRCs beyond the limit are not kept, and the first ones continue to be heard.

    The page's own reports arrive as well, with another loss.
    """
    sound = link.peer._senders["audio"]
    told = cast("Noted", link.peer._congestion).lost_
    page = link.theirs.transport
    report = RtcpReceiverInfo(sound.ssrc, 64, 0, 0, 0, 0, 0)
    for number in (*range(1, 500), *range(1, 4)):
        await page._send_rtp(bytes(RtcpRrPacket(ssrc=number, reports=[report])))
        await asyncio.sleep(0)
    assert await link.answers("still here")
    assert 20 < [share for _, share in told].count(64 / 256) <= 32 + 3
