"""A real peer on loopback: media, channels, keyframe requests and the end of it."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
from time import monotonic
from typing import TYPE_CHECKING, Any, Literal

import pytest
from aiortc import RTCPeerConnection, RTCSessionDescription
from aiortc.rtp import RtcpPsfbPacket, RtcpRtpfbPacket, RtpPacket
from av.packet import Packet

from wax.errors import SignallingError
from wax.media.encoded import VIDEO_TIME_BASE
from wax.rtc import private
from wax.rtc.peer import Peer
from wax.streams.streams import Codecs

if TYPE_CHECKING:
    from collections.abc import AsyncIterator


@dataclass(frozen=True)
class Timed:
    packet: Packet[Any]
    captured_s: float


class Ticking:
    """A lane that gives a small packet every 10 ms."""

    def __init__(self) -> None:
        self.number = 0

    async def get(self) -> Timed:
        await asyncio.sleep(0.01)
        self.number += 1
        packet: Packet[Any] = Packet(b"\x00\x00\x00\x01\x41" + b"\x80" * 60)
        packet.pts = 90_000 * 5 + 900 * self.number
        packet.time_base = VIDEO_TIME_BASE
        return Timed(packet, 5 + self.number / 100)


@dataclass
class Events:
    """Notes what the peer tells."""

    seen: list[tuple[str, object]] = field(default_factory=list)
    news: asyncio.Event = field(default_factory=asyncio.Event)

    def _note(self, what: str, value: object = None) -> None:
        self.seen.append((what, value))
        self.news.set()

    def connected(self) -> None:
        self._note("connected")

    def ready(self) -> None:
        self._note("ready")

    def received(self, channel: str, data: str | bytes) -> None:
        self._note(f"received {channel}", data)

    def keyframe_wanted(self) -> None:
        self._note("keyframe")

    def rtp_clock(self, kind: str, rtp: int, captured_s: float) -> None:
        self._note(f"clock {kind}", (rtp, captured_s))

    def closed(self, peer: Peer) -> None:
        self._note("closed")

    async def wait(self, what: str) -> object:
        async with asyncio.timeout(10):
            while True:
                for name, value in self.seen:
                    if name == what:
                        return value
                self.news.clear()
                await self.news.wait()


@dataclass
class Pair:
    """A peer of ours and the browser's side of it."""

    events: Events
    peer: Peer
    browser: RTCPeerConnection
    channels: dict[str, Any]
    lane: Ticking


@pytest.fixture(params=["vp8", "h264"])
async def pair(request: pytest.FixtureRequest) -> AsyncIterator[Pair]:
    private.install()
    codec: Literal["vp8", "h264"] = request.param
    events = Events()
    lane = Ticking()
    peer = Peer(
        ice_servers=[],
        codecs=Codecs(audio="opus", video=codec),
        video=lane,
        audio=Ticking(),
        events=events,
        now_s=monotonic,
        round_trip_s=lambda: 0.5,
    )
    browser = RTCPeerConnection()
    browser.addTransceiver("audio", direction="recvonly")
    browser.addTransceiver("video", direction="recvonly")
    channels = {
        "drive": browser.createDataChannel("drive", ordered=False, maxRetransmits=0),
        "state": browser.createDataChannel("state"),
    }
    await browser.setLocalDescription(await browser.createOffer())
    answer = await peer.answer(browser.localDescription.sdp)
    await browser.setRemoteDescription(RTCSessionDescription(answer, "answer"))
    await events.wait("ready")
    yield Pair(events, peer, browser, channels, lane)
    await peer.close()
    await browser.close()


async def test_messages_go_both_ways(pair: Pair) -> None:
    """Text on either channel arrives under that channel's name, and answers come back."""
    got: asyncio.Queue[str] = asyncio.Queue()
    pair.channels["state"].on("message", got.put_nowait)
    pair.channels["drive"].send("up")
    pair.channels["state"].send("join")
    assert await pair.events.wait("received drive") == "up"
    assert await pair.events.wait("received state") == "join"
    pair.peer.send("state", "hello")
    assert await asyncio.wait_for(got.get(), 5) == "hello"


async def test_the_rtp_clock_is_the_one_on_the_wire(
    pair: Pair, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Capture times reckoned from the told RTP clock are those of the packets on the wire."""
    told = await pair.events.wait("clock video")
    assert isinstance(told, tuple)
    rtp, captured_s = told
    sender = pair.peer._senders["video"]
    wire: asyncio.Queue[bytes] = asyncio.Queue()
    monkeypatch.setattr(sender.transport, "_send_rtp", wire.put)
    while (packet := RtpPacket.parse(await asyncio.wait_for(wire.get(), 5))).ssrc != sender._ssrc:
        pass
    lane = pair.lane
    elapsed_s = (packet.timestamp - rtp) % 2**32 / 90_000
    assert captured_s + elapsed_s == pytest.approx(5 + lane.number / 100, abs=1e-6)
    media_time = pair.peer.media_time("video", packet.timestamp)
    assert media_time is not None
    assert media_time == round((captured_s + elapsed_s) * 90_000)
    assert pair.peer.rtp_time("video", media_time) == packet.timestamp


async def test_a_lost_packet_is_sent_again_once_a_round_trip(
    pair: Pair, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A browser that asks ten times for one packet gets one copy, not ten."""
    sender = pair.peer._senders["video"]
    wire: asyncio.Queue[bytes] = asyncio.Queue()
    monkeypatch.setattr(sender.transport, "_send_rtp", wire.put)
    while (packet := RtpPacket.parse(await asyncio.wait_for(wire.get(), 5))).ssrc != sender._ssrc:
        pass
    asked = RtcpRtpfbPacket(fmt=1, ssrc=1, media_ssrc=sender._ssrc, lost=[packet.sequence_number])
    copies = 0
    for _ in range(10):
        while not wire.empty():
            wire.get_nowait()
        await sender._handle_rtcp_packet(asked)
        copies += wire.qsize()
    assert copies == 1


async def test_a_lost_picture_asks_for_a_keyframe(pair: Pair) -> None:
    """PLI, which aiortc forgets for packet tracks, reaches the encoder."""
    sender = pair.peer._senders["video"]
    await sender._handle_rtcp_packet(RtcpPsfbPacket(fmt=1, ssrc=1, media_ssrc=sender._ssrc))
    await pair.events.wait("keyframe")


async def test_a_page_that_closes_is_noticed_at_once(pair: Pair) -> None:
    """When the page closes its peer, ours is closed too and says so once."""
    await pair.browser.close()
    await pair.events.wait("closed")
    await pair.peer.close()
    assert [what for what, _ in pair.events.seen].count("closed") == 1
    assert not pair.peer.is_alive


async def test_a_close_that_fails_still_ends_the_peer(
    pair: Pair, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever aiortc raises at the end, the viewer hears that his peer is gone."""
    close = pair.peer._pc.close

    async def failing() -> None:
        await close()
        raise OSError("half closed")

    monkeypatch.setattr(pair.peer._pc, "close", failing)
    await pair.peer.close()
    await pair.events.wait("closed")


async def test_no_outside_host_is_asked(pair: Pair) -> None:
    """Without configured ICE servers there are none, not aiortc's public default."""
    gatherer = pair.peer._senders["video"].transport.transport.iceGatherer
    connection = gatherer._connection
    assert (connection.stun_server, connection.turn_server) == (None, None)


async def test_nothing_is_sent_after_the_end(pair: Pair) -> None:
    """Sending to a closed peer is no error."""
    await pair.peer.close()
    pair.peer.send("state", "late")


async def test_garbage_is_refused_with_a_sentence() -> None:
    """An offer that aiortc stumbles over is a refusal, and leaves nothing open."""
    private.install()
    events = Events()
    peer = Peer(
        ice_servers=[],
        codecs=Codecs(audio="opus", video="vp8"),
        video=Ticking(),
        audio=Ticking(),
        events=events,
        now_s=monotonic,
        round_trip_s=lambda: 0.5,
    )
    sections = [f"m={kind} 9 UDP/TLS/RTP/SAVPF x" for kind in ("audio", "video", "application")]
    with pytest.raises(SignallingError, match="cannot be answered"):
        await peer.answer("\r\n".join(["v=0", *sections]))
    assert not peer.is_alive
    assert events.seen == [("closed", None)]
