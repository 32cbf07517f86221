"""One of the crowd: the bench's viewer, but cheap to receive with, and answering as Chromium does.

Here, and in `e2e.bench.receiver`, the lab touches private parts of aiortc and aioice. Packets of
media are read where the socket has them, before aiortc would decrypt and queue them; all else goes
its way.
"""

from __future__ import annotations

import asyncio
import time
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Final, Literal

import pylibsrtp
from aiortc.codecs import CODECS, HEADER_EXTENSIONS
from aiortc.rtcrtpparameters import RTCRtcpFeedback, RTCRtpHeaderExtensionParameters

from e2e.bench.receiver import CountedStream
from e2e.bench.viewer import Offering, Viewer
from e2e.lab.crowd import header
from e2e.lab.crowd.feedback import URI, Feedback, every_s
from e2e.lab.crowd.line import Way
from e2e.lab.crowd.missing import Missing
from e2e.measure.errors import MeasureError

if TYPE_CHECKING:
    import aiohttp
    from aiortc import RTCRtpReceiver

    from e2e.lab.crowd.header import Header

_EXTENSION_IDS: Final = {
    URI: 5,
    "http://www.webrtc.org/experiments/rtp-hdrext/playout-delay": 6,
}
_CLOCK_RATE_HZ: Final = {"audio": 48_000, "video": 90_000}
_RTX: Final = "rtx"
_LOOK_EVERY_S: Final = 0.05
Kind = Literal["audio", "video"]


@dataclass(frozen=True, slots=True)
class Agreed:
    """What an answer says of the packets to come."""

    kinds: dict[int, Kind]
    """By payload type."""
    repeats: frozenset[int]
    """Payload types of retransmissions (RFC 4588)."""
    extension_id: int | None
    """Of the transport-wide sequence number; None where the server takes no such feedback."""


class Onlooker(Viewer):
    """A `Viewer` whose receiving costs little; `line` seeds the modem that it is behind, if any."""

    def __init__(self, offering: Offering, *, line: int | None = None) -> None:
        super().__init__(offering)
        self.feedbacks = 0
        self.repeats_asked = 0
        self.keyframes_asked = 0
        self._line = line
        self._ways: list[Way] = []
        self._feedback = Feedback()
        self._missing: dict[int, Missing] = {}
        self._agreed = Agreed({}, frozenset(), None)
        self._bytes = 0
        self._told_bytes = 0
        self._told_s = time.monotonic()

    async def close(self) -> None:
        for way in self._ways:
            way.close()
        await super().close()

    async def tell(self, now_s: float) -> None:
        """Send what a browser would send now; called every hundredth of a second."""
        video = self._streams.get("video", {})
        if not video:
            return
        receiver = self._receivers()["video"]
        with suppress(ConnectionError):
            await self._tell_arrivals(now_s, receiver, next(iter(video)))
            for ssrc, missing in self._missing.items():
                lost, wants_keyframe = missing.due(now_s)
                if lost:
                    self.repeats_asked += len(lost)
                    await receiver._send_rtcp_nack(ssrc, lost)
                if wants_keyframe:
                    self.keyframes_asked += 1
                    await receiver._send_rtcp_pli(ssrc)

    async def _tell_arrivals(self, now_s: float, receiver: RTCRtpReceiver, ssrc: int) -> None:
        passed_s = now_s - self._told_s
        if passed_s < every_s(8 * (self._bytes - self._told_bytes) / max(0.001, passed_s)):
            return
        sender_ssrc = getattr(receiver, "_RTCRtpReceiver__rtcp_ssrc")  # noqa: B009  # mypy: not its
        packet = self._feedback.take(sender_ssrc, ssrc)
        if packet is not None:
            self.feedbacks += 1
            self._told_s, self._told_bytes = now_s, self._bytes
            await receiver.transport._send_rtp(packet)

    async def _negotiate(self, http: aiohttp.ClientSession) -> None:
        await super()._negotiate(http)
        # Nothing of the answer has been acted on yet: that is a task of its own.
        self._agreed = agreed(self._peer.remoteDescription.sdp)
        for protocol in _protocols(self._receivers()["video"]):
            self._tap(protocol)
        if self._line is not None:
            # What gets through to him is the server's to see to: he is there when he is connected.
            while self._peer.connectionState != "connected":  # noqa: ASYNC110  # bounded by `connect`
                await asyncio.sleep(_LOOK_EVERY_S)
            for arrived in self._arrived.values():
                arrived.set()

    def _tap(self, protocol: Any) -> None:
        onwards = protocol.datagram_received

        def take(data: bytes, address: Any) -> None:
            if not header.is_rtp(data):
                onwards(data, address)
            elif (packet := header.read(data, self._agreed.extension_id)) is not None:
                self._take_packet(data, packet)

        protocol.datagram_received = take
        if self._line is not None:
            down = Way("down", self._line, take)
            up = Way("up", self._line, partial(_send, protocol.transport))
            self._ways += [down, up]
            protocol.datagram_received = down.carry
            protocol.transport = _Through(protocol.transport, up)

    def _take_packet(self, data: bytes, packet: Header) -> None:
        self._bytes += len(data)
        if packet.transport_sequence is not None:
            self._feedback.came(packet.transport_sequence, time.monotonic())
        if packet.payload_type in self._agreed.repeats:
            self._take_repeat(data)
            return
        kind = self._agreed.kinds.get(packet.payload_type)
        if kind is None:
            return
        streams = self._streams[kind]
        stream = streams.get(packet.ssrc)
        if stream is None:
            stream = streams[packet.ssrc] = CountedStream(_CLOCK_RATE_HZ[kind])
            self._arrived[kind].set()
            if kind == "video":
                self._missing[packet.ssrc] = Missing()
        stream.add(packet)  # type: ignore[arg-type]  # it has all of a packet that is looked at
        if kind == "video":
            self._missing[packet.ssrc].came(packet.sequence_number)
        if self._receipts is not None:
            self._came(kind, packet)  # type: ignore[arg-type]  # as above

    def _take_repeat(self, data: bytes) -> None:
        """Note which packet it repeats: the first two bytes within (RFC 4588, 4)."""
        with suppress(pylibsrtp.Error):
            clear = self._receivers()["video"].transport._rx_srtp.unprotect(data)
            inside = header.read(clear, None)
            if inside is not None and len(inside.payload) >= 2:
                for missing in self._missing.values():
                    missing.came(int.from_bytes(inside.payload[:2], "big"))

    def _receivers(self) -> dict[str, Any]:
        return {one.kind: one.receiver for one in self._peer.getTransceivers()}


class _Through:
    """A socket's transport whose datagrams go by a line first."""

    def __init__(self, transport: Any, way: Way) -> None:
        self._transport = transport
        self._way = way

    def sendto(self, data: bytes, address: Any = None) -> None:
        self._way.carry(data, address)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._transport, name)


def _send(transport: Any, data: bytes, address: Any) -> None:
    if not transport.is_closing():  # ICE gives up those of its sockets that it does not need
        transport.sendto(data, address)


def offer_as_chromium() -> None:
    """Let every offer of this process have what a browser's has and aiortc's lacks."""
    for kind, codecs in CODECS.items():
        HEADER_EXTENSIONS[kind] += [
            RTCRtpHeaderExtensionParameters(id=number, uri=uri)
            for uri, number in _EXTENSION_IDS.items()
        ]
        for codec in codecs:
            if not codec.mimeType.endswith(f"/{_RTX}"):
                codec.rtcpFeedback.append(RTCRtcpFeedback(type="transport-cc"))


def agreed(sdp: str) -> Agreed:
    """Read an answer (RFC 8866, 6.6; RFC 8285, 8)."""
    kinds: dict[int, Kind] = {}
    repeats: set[int] = set()
    extension_id = None
    kind: Kind | None = None
    for line in sdp.splitlines():
        name, _, value = line.partition(":")
        if line.startswith("m="):
            kind = "audio" if line.startswith("m=audio") else None
            kind = "video" if line.startswith("m=video") else kind
        elif name == "a=rtpmap" and kind is not None:
            number, _, codec = value.partition(" ")
            if codec.lower().startswith(_RTX):
                repeats.add(int(number))
            else:
                kinds[int(number)] = kind
        elif name == "a=extmap" and value.endswith(f" {URI}"):
            extension_id = int(value.split()[0].partition("/")[0])
    return Agreed(kinds, frozenset(repeats), extension_id)


def _protocols(receiver: Any) -> list[Any]:
    """Return what aioice has at each of its sockets; raises `MeasureError` if it has changed."""
    connection = getattr(receiver.transport.transport, "_connection", None)
    protocols = list(getattr(connection, "_protocols", ()))
    wanted = ("datagram_received", "transport")
    if not protocols or not all(hasattr(one, name) for one in protocols for name in wanted):
        raise MeasureError(
            "this aioice is built differently inside; mend e2e/lab/crowd/onlooker.py"
        )
    return protocols
