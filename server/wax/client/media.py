"""Receives media, by default without decoding, and answers as Chromium does.

The one module of the client that uses private parts of aiortc and aioice. RTP is read at the
socket, before aiortc would decrypt, buffer and decode it; everything else passes on to aiortc. Its
own counters are replaced, so that it sends correct receiver reports.
"""

from __future__ import annotations

import asyncio
import time
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Final

import pylibsrtp
from aiortc.rtcrtpreceiver import StreamStatistics
from av import VideoFrame

from wax.client import rtp_header
from wax.client.retransmission import RetransmissionRequests
from wax.client.sdp import KINDS, Agreed, Kind, agreed
from wax.client.transport_feedback import MIN_INTERVAL_S, TransportFeedback, interval_s
from wax.errors import StartError

if TYPE_CHECKING:
    from collections.abc import Callable

    from aiortc import RTCPeerConnection, RTCRtpReceiver

    from wax.client.rtp_header import RtpHeader

_CLOCK_RATE_HZ: Final[dict[Kind, int]] = {"audio": 48_000, "video": 90_000}
_UINT32: Final = 2**32
_RETRY_LOOK_S: Final = 0.01


@dataclass(slots=True)
class StreamCounts:
    """Sums over the streams of one kind since the connection began; `octets` of payload."""

    packets: int = 0
    lost: int = 0
    octets: int = 0
    frames: int = 0

    def __add__(self, other: StreamCounts) -> StreamCounts:
        return StreamCounts(
            self.packets + other.packets,
            self.lost + other.lost,
            self.octets + other.octets,
            self.frames + other.frames,
        )


@dataclass(slots=True)
class RtcpAnswers:
    """RTCP sent back: feedback packets, and requests for retransmissions and keyframes."""

    feedbacks: int = 0
    retransmissions: int = 0
    keyframes: int = 0

    def __add__(self, other: RtcpAnswers) -> RtcpAnswers:
        return RtcpAnswers(
            self.feedbacks + other.feedbacks,
            self.retransmissions + other.retransmissions,
            self.keyframes + other.keyframes,
        )


@dataclass(frozen=True, slots=True)
class FrameArrival:
    """The first packet of the newest frame; `at_s` is in seconds of `time.monotonic`."""

    rtp: int
    at_s: float


class CountedStream(StreamStatistics):
    """One SSRC, with the counts of RFC 3550, A.3, and its octets and frames."""

    def __init__(self, clock_rate_hz: int, *, is_decoded: bool) -> None:
        super().__init__(clock_rate_hz)
        self._is_decoded = is_decoded
        self.octets = 0
        self.frames = 0
        self.newest = FrameArrival(-1, 0.0)

    def count(self, packet: RtpHeader, at_s: float) -> None:
        if not self._is_decoded:  # or aiortc counts it
            self.add(packet)  # type: ignore[arg-type]  # it has all of a packet that is looked at
        self.octets += len(packet.payload)
        if packet.timestamp != self.newest.rtp:
            self.newest = FrameArrival(packet.timestamp, at_s)
            self.frames += 1


class Media:
    """Sound and picture of one peer connection, made before its offer, attached at its answer.

    `on_packet` is called with each packet of media but retransmissions; `on_socket` with aioice's
    protocol at each socket, once it is tapped. With `decodes`, aiortc gets the packets too, to ask
    for lost ones and to decode pictures. Feedback is sent by a timer, as a browser does: a
    sender that waits for feedback sends no packets that could trigger it.
    """

    def __init__(
        self,
        peer: RTCPeerConnection,
        *,
        on_packet: Callable[[Kind, RtpHeader], None] | None = None,
        on_socket: Callable[[Any], None] | None = None,
        decodes: bool = False,
        now_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self._decodes = decodes
        self.answers = RtcpAnswers()
        self.arrived = {kind: asyncio.Event() for kind in KINDS}
        self._on_packet = on_packet
        self._on_socket = on_socket
        self._now_s = now_s
        self._receivers = {
            kind: peer.addTransceiver(kind, direction="recvonly").receiver for kind in KINDS
        }
        self._streams = {kind: _statistics(one) for kind, one in self._receivers.items()}
        self._agreed = Agreed({}, frozenset(), None)
        self._feedback = TransportFeedback()
        self._requests: dict[int, RetransmissionRequests] = {}
        self._octets = self._told_octets = 0
        self._told_s = now_s()
        self._feedback_s = self._told_s + MIN_INTERVAL_S
        self._request_s = 0.0
        self._answering: asyncio.Task[None] | None = None
        self._due: asyncio.TimerHandle | None = None

    def attach(self, answer: str) -> None:
        """Tap the sockets; call it in the same step as setting the answer, before ICE begins.

        Raises `StartError` if the internals of this aiortc or aioice differ.
        """
        self._agreed = agreed(answer)
        for protocol in _protocols(self._receivers["video"]):
            protocol.datagram_received = partial(self._received, protocol.datagram_received)
            if self._on_socket is not None:
                self._on_socket(protocol)

    def counts(self, kind: Kind) -> StreamCounts:
        total = StreamCounts()
        for stream in self._streams[kind].values():
            total.packets += stream.packets_received
            total.lost += stream.packets_expected - stream.packets_received
            total.octets += stream.octets
            total.frames += stream.frames
        return total

    def newest(self, kind: Kind) -> FrameArrival | None:
        """Return when the newest frame began to arrive, None before the first."""
        found = [stream.newest for stream in self._streams[kind].values()]
        return max(found, key=lambda one: one.at_s, default=None)

    async def picture(self) -> tuple[int, VideoFrame]:
        """Return the newest picture and its RTP time, once there is one that was not returned.

        Older ones are dropped. Raises `MediaStreamError` after the end; needs `decodes`.
        """
        receiver = self._receivers["video"]
        frame = await receiver.track.recv()
        with suppress(TimeoutError):
            async with asyncio.timeout(0):
                while True:  # what is there is returned at once
                    frame = await receiver.track.recv()
        assert isinstance(frame, VideoFrame)
        assert frame.pts is not None
        mapper: Any = getattr(receiver, "_RTCRtpReceiver__timestamp_mapper")  # noqa: B009  # as above
        return (frame.pts + mapper._origin) % _UINT32, frame

    async def close(self) -> None:
        """Finish sending."""
        self._remind(None)
        if self._answering is not None:
            await self._answering

    def _received(self, onwards: Callable[[bytes, Any], None], data: bytes, address: Any) -> None:
        if not rtp_header.is_rtp(data):
            onwards(data, address)
        elif (packet := rtp_header.read(data, self._agreed.extension_id)) is not None:
            self._take(data, packet, self._now_s())
            if self._decodes:
                onwards(data, address)

    def _take(self, data: bytes, packet: RtpHeader, now_s: float) -> None:
        self._octets += len(data)
        if packet.transport_sequence is not None:
            self._feedback.arrived(packet.transport_sequence, now_s)
        kind = self._agreed.kinds.get(packet.payload_type)
        if packet.payload_type in self._agreed.retransmissions:
            if not self._decodes:
                self._take_retransmission(data)
        elif kind is not None:
            self._count(kind, packet, now_s)
        self._answer_if_due(now_s)

    def _answer_if_due(self, now_s: float) -> None:
        if self._answering is not None:
            return
        if self._is_due(now_s):
            self._remind(None)
            self._answering = asyncio.create_task(self._answer(now_s), name="RTCP")
        elif self._due is None:
            self._remind(self._feedback_s - now_s)

    def _remind(self, after_s: float | None) -> None:
        """Check again after this time whether an answer is due; None for never."""
        if self._due is not None:
            self._due.cancel()
            self._due = None
        if after_s is not None:
            self._due = asyncio.get_running_loop().call_later(after_s, self._reminded)

    def _reminded(self) -> None:
        self._due = None
        self._answer_if_due(self._now_s())

    def _count(self, kind: Kind, packet: RtpHeader, now_s: float) -> None:
        stream = self._streams[kind].get(packet.ssrc)
        if stream is None:
            stream = self._streams[kind][packet.ssrc] = CountedStream(
                _CLOCK_RATE_HZ[kind], is_decoded=self._decodes
            )
            self.arrived[kind].set()
            if kind == "video":
                self._requests[packet.ssrc] = RetransmissionRequests()
        stream.count(packet, now_s)
        if kind == "video" and not self._decodes:
            self._requests[packet.ssrc].arrived(packet.sequence_number)
        if self._on_packet is not None:
            self._on_packet(kind, packet)

    def _take_retransmission(self, data: bytes) -> None:
        """Count a retransmission; its first two octets name the original packet (RFC 4588, 4)."""
        with suppress(pylibsrtp.Error):
            clear = self._receivers["video"].transport._rx_srtp.unprotect(data)
            inside = rtp_header.read(clear, None)
            if inside is not None and len(inside.payload) >= 2:
                for requests in self._requests.values():
                    requests.arrived(int.from_bytes(inside.payload[:2], "big"))

    def _is_due(self, now_s: float) -> bool:
        if now_s >= self._feedback_s:
            return True
        missing = any(not requests.is_empty for requests in self._requests.values())
        return missing and now_s >= self._request_s

    async def _answer(self, now_s: float) -> None:
        try:
            with suppress(ConnectionError):  # closed in between
                if now_s >= self._feedback_s:
                    await self._send_feedback(now_s)
                self._request_s = now_s + _RETRY_LOOK_S
                for ssrc, requests in self._requests.items():
                    await self._ask(ssrc, *requests.due(now_s))
        finally:
            self._answering = None

    async def _send_feedback(self, now_s: float) -> None:
        receiver = self._receivers["video"]
        rate_bps = 8 * (self._octets - self._told_octets) / max(0.001, now_s - self._told_s)
        self._told_s, self._told_octets = now_s, self._octets
        self._feedback_s = now_s + interval_s(rate_bps)
        sender_ssrc = getattr(receiver, "_RTCRtpReceiver__rtcp_ssrc")  # noqa: B009  # mypy: not its
        media_ssrc = next(iter(self._requests), None)
        if sender_ssrc is None or media_ssrc is None:
            return
        packet = self._feedback.take(sender_ssrc, media_ssrc)
        if packet is not None:
            self.answers.feedbacks += 1
            await receiver.transport._send_rtp(packet)

    async def _ask(self, ssrc: int, missing: list[int], wants_keyframe: bool) -> None:
        receiver = self._receivers["video"]
        if missing:
            self.answers.retransmissions += len(missing)
            await receiver._send_rtcp_nack(ssrc, missing)
        if wants_keyframe:
            self.answers.keyframes += 1
            await receiver._send_rtcp_pli(ssrc)


def _statistics(receiver: RTCRtpReceiver) -> dict[int, CountedStream]:
    """Return aiortc's storage for the counts in its receiver reports."""
    streams: dict[int, CountedStream] | None = getattr(
        receiver, "_RTCRtpReceiver__remote_streams", None
    )
    wanted = (
        "_send_rtcp_nack",
        "_send_rtcp_pli",
        "_RTCRtpReceiver__rtcp_ssrc",
    )
    mapper = getattr(receiver, "_RTCRtpReceiver__timestamp_mapper", None)
    has_all = all(hasattr(receiver, name) for name in wanted) and hasattr(mapper, "_origin")
    transport = receiver.transport
    if streams is None or not has_all or not hasattr(transport, "_rx_srtp"):
        raise _moved("aiortc")
    return streams


def _protocols(receiver: RTCRtpReceiver) -> list[Any]:
    """Return aioice's protocol at each of its sockets."""
    connection = getattr(receiver.transport.transport, "_connection", None)
    protocols = list(getattr(connection, "_protocols", ()))
    wanted = ("datagram_received", "transport")
    if not protocols or not all(hasattr(one, name) for one in protocols for name in wanted):
        raise _moved("aioice")
    return protocols


def _moved(library: str) -> StartError:
    return StartError(
        f"this version of {library} is not the one that wax.client was built for;"
        " install the versions of requirements.lock"
    )
