"""A real peer's voice on loopback, and voices that were not negotiated."""

from __future__ import annotations

import asyncio
import gc
import weakref
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

import numpy as np
from aiortc import RTCPeerConnection
from aiortc.mediastreams import AudioStreamTrack
from tests.rtc.networks import opened_network
from tests.rtc.real_peer import Events, agree, peer_of

from wax.speaker.opus_decoder import OpusDecoder

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

    from aiortc import RTCDtlsTransport

    from wax.rtc.peer import Peer
    from wax.voice.packet import VoicePacket

Heard = asyncio.Queue["VoicePacket | None"]


@asynccontextmanager
async def connected(
    direction: str, on_voice: Callable[[VoicePacket | None], None] | None
) -> AsyncIterator[tuple[Peer, RTCPeerConnection, str]]:
    """Connect a peer of ours with a browser that sends sound if it may; yield the answer, too."""
    async with opened_network("one-port") as opened:
        events = Events()
        browser = RTCPeerConnection()
        browser.addTransceiver(AudioStreamTrack(), direction=direction)
        browser.addTransceiver("video", direction="recvonly")
        browser.createDataChannel("drive", ordered=False, maxRetransmits=0)
        browser.createDataChannel("state")
        peer = peer_of(opened, events, on_voice=on_voice)
        answer = await agree(peer, browser)
        await events.wait("ready")
        left, held = weakref.ref(peer), [peer]
        del peer  # the test must hold the only reference
        yield held.pop(), browser, answer
        if (one := left()) is not None:
            await one.close()
        await browser.close()


def of_sound(answer: str) -> str:
    return answer.partition("m=audio")[2].partition("m=video")[0]


async def test_a_voice_arrives_packet_by_packet() -> None:
    """Each packet is handed over on arrival, without a thread and without 80 ms of buffering."""
    heard: Heard = asyncio.Queue()
    async with connected("sendrecv", heard.put_nowait) as (peer, _, answer):
        assert "a=sendrecv" in of_sound(answer)
        decoder = OpusDecoder()
        packets = [await asyncio.wait_for(heard.get(), 5) for _ in range(5)]
        for packet in packets:
            assert packet is not None
            assert packet.samples == 960
            assert np.abs(decoder.decode(packet)).max() < 10  # its track is silence
        numbers = [packet.timestamp for packet in packets if packet is not None]
        assert list(np.diff(numbers)) == [960] * 4
        assert peer._senders["audio"].transport._rtp_router.receivers == set()
        assert peer.is_alive


async def test_a_page_without_a_voice_gets_a_sendonly_answer() -> None:
    """A page that offers only to receive sound gets a sendonly answer, voice or not."""
    heard: Heard = asyncio.Queue()
    async with connected("recvonly", heard.put_nowait) as (_, _, answer):
        assert "a=sendonly" in of_sound(answer)
    assert heard.empty()


async def test_without_voice_nothing_is_received() -> None:
    """A server without a speaker answers sendonly and receives nothing."""
    async with connected("sendrecv", None) as (peer, _, answer):
        assert "a=sendonly" in of_sound(answer)
        transport = _transport(peer)
        await transport._handle_rtp_data(b"\x80\x6f" + bytes(30), arrival_time_ms=0)
        assert not transport._rtp_router.receivers
        assert not transport._rtp_router.ssrc_table


def _transport(peer: Peer) -> RTCDtlsTransport:
    return peer._senders["audio"].transport


async def test_unreadable_packets_are_reported() -> None:
    """Bytes that are no voice packet are reported, and never end the peer."""
    heard: Heard = asyncio.Queue()
    async with connected("sendrecv", heard.put_nowait) as (peer, _, _):
        await asyncio.wait_for(heard.get(), 5)
        for data in (b"", b"\x80", b"\x80\x6f" + bytes(9), b"\x80\x60" + bytes(10), bytes(2000)):
            await _transport(peer)._handle_rtp_data(data, arrival_time_ms=0)
            while await asyncio.wait_for(heard.get(), 5) is not None:
                pass
            assert peer.is_alive, data


async def test_made_up_streams_are_not_remembered() -> None:
    """A page that makes up an SSRC for each packet makes no table grow."""
    heard: Heard = asyncio.Queue()
    async with connected("sendrecv", heard.put_nowait) as (peer, _, _):
        await asyncio.wait_for(heard.get(), 5)
        transport = _transport(peer)
        for ssrc in range(1000):
            data = b"\x80\x60" + bytes(6) + ssrc.to_bytes(4, "big") + b"\x08voice"
            await transport._handle_rtp_data(data, arrival_time_ms=0)
        assert transport._rtp_router.ssrc_table == {}


async def test_a_closed_peer_with_a_voice_is_freed_at_once() -> None:
    """A closed peer's receiver keeps nothing alive."""
    heard: Heard = asyncio.Queue()
    gc.disable()
    try:
        async with connected("sendrecv", heard.put_nowait) as (peer, _, _):
            await asyncio.wait_for(heard.get(), 5)
            pc = peer._pc
            left = [weakref.ref(one) for one in (pc, *pc.getReceivers(), _transport(peer))]
            await peer.close()
            del peer, pc
            for _ in range(200):
                if any(one() is not None for one in left):
                    await asyncio.sleep(0.02)
            assert [one() for one in left if one() is not None] == []
    finally:
        gc.enable()
