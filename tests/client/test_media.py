"""What goes back to the server for the packets that arrive, and when."""

from __future__ import annotations

import asyncio
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import pytest
from aiortc import RTCConfiguration, RTCPeerConnection
from aiortc.rtcrtpparameters import RTCRtpHeaderExtensionParameters, RTCRtpParameters
from aiortc.rtp import HeaderExtensions, HeaderExtensionsMap, RtpPacket

from wax.client.media import Media
from wax.client.transport_feedback import URI

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

ANSWER = f"""v=0
m=audio 9 UDP/TLS/RTP/SAVPF 96
a=rtpmap:96 opus/48000/2
a=extmap:5 {URI}
m=video 9 UDP/TLS/RTP/SAVPF 97 98
a=rtpmap:97 VP8/90000
a=rtpmap:98 rtx/90000
"""


class Wire:
    """A peer whose socket is fed by hand, on a clock of its own, and what it sends back."""

    def __init__(self, peer: RTCPeerConnection, monkeypatch: pytest.MonkeyPatch) -> None:
        self.at_s = 100.0
        self.feedback_s: list[float] = []
        self.told = asyncio.Event()
        self.asked: list[tuple[float, list[int]]] = []
        self.keyframes_s: list[float] = []
        self.onwards: list[bytes] = []
        self.sockets: list[Any] = []
        self.media = Media(peer, on_socket=self.sockets.append, now_s=lambda: self.at_s)
        self._sequence = 0
        self._extensions = HeaderExtensionsMap()
        extension = RTCRtpHeaderExtensionParameters(id=5, uri=URI)
        self._extensions.configure(RTCRtpParameters(headerExtensions=[extension]))
        receiver: Any = peer.getTransceivers()[1].receiver
        receiver._set_rtcp_ssrc(1)
        monkeypatch.setattr(receiver, "_send_rtcp_nack", self._nack)
        monkeypatch.setattr(receiver, "_send_rtcp_pli", self._pli)
        monkeypatch.setattr(receiver.transport, "_send_rtp", self._feedback)

    async def brings(self, sequence: int, *, pause_s: float = 0.01, size: int = 1000) -> None:
        """Let a picture's packet arrive, and let the resulting answers be sent."""
        self.at_s += pause_s
        self._sequence += 1
        packet = RtpPacket(payload_type=97, sequence_number=sequence, ssrc=7, payload=bytes(size))
        packet.timestamp = sequence // 4
        packet.extensions = HeaderExtensions(transport_sequence_number=self._sequence)
        self.sockets[0].datagram_received(packet.serialize(self._extensions), ("127.0.0.1", 9))
        await asyncio.sleep(0)
        await asyncio.sleep(0)

    async def _feedback(self, data: bytes) -> None:
        self.feedback_s.append(self.at_s)
        self.told.set()

    async def _nack(self, ssrc: int, lost: list[int]) -> None:
        self.asked.append((self.at_s, lost))

    async def _pli(self, ssrc: int) -> None:
        self.keyframes_s.append(self.at_s)


@pytest.fixture
async def wire(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Wire]:
    peer = RTCPeerConnection(RTCConfiguration(iceServers=[]))
    wire = Wire(peer, monkeypatch)
    await peer.setLocalDescription(await peer.createOffer())
    receiver: Any = peer.getTransceivers()[1].receiver
    for socket in receiver.transport.transport._connection._protocols:
        socket.datagram_received = lambda data, _: wire.onwards.append(data)
    wire.media.attach(ANSWER)
    yield wire
    await peer.close()
    await wire.media.close()


async def test_feedback_goes_back_each_50_to_100_ms(wire: Wire) -> None:
    """At any rate, feedback is sent every 50 to 100 ms with each packet's arrival time."""
    for sequence in range(300):
        await wire.brings(sequence)
    gaps_s = [after - before for before, after in pairwise(wire.feedback_s)]
    assert len(gaps_s) > 25
    assert min(gaps_s) >= 0.05
    assert max(gaps_s) <= 0.1


async def test_the_last_packet_is_told_of_though_none_follows(wire: Wire) -> None:
    """The last packet is reported without another one: the sender may be waiting for that."""
    await wire.brings(1)
    assert wire.feedback_s == []
    wire.at_s += 0.1
    await asyncio.wait_for(wire.told.wait(), 10.0)


async def test_a_missing_packet_is_asked_for_at_once_and_again(wire: Wire) -> None:
    """A missing packet is requested at once, again every 100 ms, and finally as a keyframe."""
    for sequence in (1, 2, 4):
        await wire.brings(sequence)
    assert wire.asked == [(wire.at_s, [3])]
    for sequence in range(5, 150):
        await wire.brings(sequence)
    assert [lost for _, lost in wire.asked] == [[3]] * 10
    assert all(0.1 <= b - a <= 0.12 for (a, _), (b, _) in pairwise(wire.asked))
    assert len(wire.keyframes_s) == 1


async def test_only_media_are_taken_from_the_socket(wire: Wire) -> None:
    """RTCP, DTLS and STUN are passed to aiortc; sound and picture are only counted."""
    for first in (0, 22, 0x80):
        wire.sockets[0].datagram_received(bytes([first, 200, *range(20)]), None)
    assert len(wire.onwards) == 3
    sound = bytes([0x80, 96, 0, 1, 0, 0, 0, 9, 0, 0, 0, 5, 1, 2])
    wire.sockets[0].datagram_received(sound, None)
    assert len(wire.onwards) == 3
    counts = wire.media.counts("audio")
    assert (counts.packets, counts.octets, counts.frames) == (1, 2, 1)
