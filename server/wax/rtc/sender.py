"""One stream to one browser: a replacement for aiortc's RTCRtpSender that reads from a lane.

aiortc's own encodes for each viewer, has no pacing and no transport-wide numbers, retransmits
without limit, reports the time of sending as that of capture, and loses keyframe requests. This one
sends what was encoded for everybody, and asks congestion control before a picture leaves.
"""

from __future__ import annotations

import asyncio
import random
from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Final, Literal

import structlog
from aiortc.rtp import RtcpRrPacket

from wax.congestion.delivery import UDP_IP_BYTES
from wax.rtc import private, rtp
from wax.rtc.receiver_reports import SenderReportTimes

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine

    from aiortc import RTCRtpSender
    from aiortc.rtcrtpparameters import RTCRtpSendParameters
    from aiortc.rtp import AnyRtcpPacket, RtcpReceiverInfo

    from wax.clock import Clock
    from wax.rtc.lane import Encoded
    from wax.rtc.sent_history import SentPacket
    from wax.rtc.transport_tap import TransportTap

_LOG = structlog.get_logger(__name__)

UINT16: Final = 2**16
UINT32: Final = 2**32
_REPORT_S: Final = 1.0
"""The mean time between sender reports (RFC 3550, 6.2 lets it vary by half)."""
_SRTP_BYTES: Final = 10
"""Authentication tag of the profile that Chromium negotiates (RFC 3711)."""
_RTP_BYTES: Final = 20
"""Header with the extension that every packet has."""


@dataclass(frozen=True, slots=True)
class SenderContext:
    """What a sender needs; it replaces `stock` and takes over its identity.

    `rate_hz` is the stream's RTP clock. `on_sent` is called with each item once it is fully sent.
    """

    stock: RTCRtpSender
    rate_hz: int
    tap: TransportTap
    clock: Clock
    on_sent: Callable[[Encoded], None]


class Sender(private.SenderInPlace):
    """The common part of both senders."""

    kind: ClassVar[Literal["audio", "video"]]

    def __init__(self, context: SenderContext) -> None:
        # A browser delays sound in the same stream for a late picture; here the sound is the master
        # and only sync/ couples them.
        super().__init__(context.stock, f"wax-{self.kind}")
        self.origin = random.getrandbits(32)
        """The RTP time of media time zero, random by RFC 3550, 5.1."""
        self.failed = False
        self._tap = context.tap
        self._now_s = context.clock.now_s
        self._wall_ms = context.clock.wall_ms
        self._rate_hz = context.rate_hz
        self._on_sent = context.on_sent
        self._sequence_number = random.getrandbits(15)
        self._ids = rtp.ExtensionIds()
        self._cname = ""
        self._payload_type = 0
        self._extra_payload_type: int | None = None
        self._packets = 0
        self._octets = 0
        self._newest: tuple[int, float] | None = None
        self._reported = SenderReportTimes()
        self._tasks: list[asyncio.Task[None]] = []

    # --- the transceiver's interface -------------------------------------------------------

    def begin(self, parameters: RTCRtpSendParameters) -> None:
        self._tap.join(self.transport)
        numbers = {one.uri: one.id for one in parameters.headerExtensions}
        self._ids = rtp.ExtensionIds(
            transport_sequence=numbers.get(rtp.TRANSPORT_SEQUENCE),
            playout_delay=numbers.get(rtp.PLAYOUT_DELAY),
        )
        has_feedback = self._ids.transport_sequence is not None
        self._tap.congestion.negotiated(has_feedback=has_feedback, kind=self.kind)
        self._cname = parameters.rtcp.cname or ""
        self._payload_type = parameters.codecs[0].payloadType or 0
        extra = next((c for c in parameters.codecs if c.name.lower() == self._extra_name), None)
        self._extra_payload_type = None if extra is None else extra.payloadType
        self._tasks = [
            asyncio.create_task(self._guard(self._run_lane()), name=f"send {self.kind}"),
            asyncio.create_task(self._guard(self._report()), name=f"report {self.kind}"),
        ]

    async def end(self) -> None:
        tasks, self._tasks = self._tasks, []  # a cancelled task holds its sender
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    def heard(self, packet: AnyRtcpPacket) -> None:
        if isinstance(packet, RtcpRrPacket):
            for report in packet.reports:
                if report.ssrc == self.ssrc:
                    self._told(report, self._now_s())
        else:
            self._asked(packet)

    def _told(self, report: RtcpReceiverInfo, now_s: float) -> None:
        self._tap.congestion.lost(report.fraction_lost / 256, now_s, self.kind)
        trip_s = self._reported.round_trip_s(report.lsr, report.dlsr, now_s)
        if trip_s is not None:
            self._tap.congestion.round_trip(trip_s, now_s)

    # --- what the two kinds do differently -------------------------------------------------

    _extra_name: ClassVar[str]
    """The companion of the stream's codec."""

    @abstractmethod
    async def _run_lane(self) -> None:
        """Send the lane's items, for ever."""

    @abstractmethod
    def _asked(self, packet: AnyRtcpPacket) -> None:
        """Handle the browser's requests."""

    # --- sending ---------------------------------------------------------------------------

    async def _guard(self, work: Coroutine[None, None, None]) -> None:
        """Close the peer when either of its tasks ends."""
        try:
            await work
        except ConnectionError:
            pass  # the transport is closed, and the peer will be
        except Exception:
            _LOG.exception("a sender failed", kind=self.kind)
        self.failed = True

    async def _send(
        self,
        *,
        payload_type: int,
        sequence_number: int,
        ssrc: int,
        packet: SentPacket,
        train: int | None = None,
        playout_delay: rtp.PlayoutDelay | None = None,
        repeat: bool = False,
    ) -> int:
        """Send one packet now; return its size on the wire."""
        extensions = b""
        size = len(packet.payload) + _RTP_BYTES + _SRTP_BYTES + UDP_IP_BYTES
        if self._ids.transport_sequence is not None or playout_delay is not None:
            kind: Literal["audio", "video", "repeat"] = "repeat" if repeat else self.kind
            extensions = rtp.extension_block(
                self._ids,
                transport_sequence=(
                    None
                    if self._ids.transport_sequence is None
                    else self._tap.mark(size, kind, train)
                ),
                playout_delay=playout_delay,
            )
        data = rtp.rtp_packet(
            payload_type=payload_type,
            marker=packet.marker,
            sequence_number=sequence_number,
            timestamp=packet.timestamp,
            ssrc=ssrc,
            extensions=extensions,
            payload=packet.payload,
        )
        await self.put(data)
        return size

    async def _send_new(
        self,
        payload_type: int,
        packet: SentPacket,
        *,
        train: int | None = None,
        playout_delay: rtp.PlayoutDelay | None = None,
    ) -> tuple[int, int]:
        """Send the next packet of the stream; return its number and its size on the wire."""
        number = self._sequence_number
        self._sequence_number = (number + 1) % UINT16
        size = await self._send(
            payload_type=payload_type,
            sequence_number=number,
            ssrc=self.ssrc,
            packet=packet,
            train=train,
            playout_delay=playout_delay,
        )
        self._packets += 1
        self._octets += len(packet.payload)
        return number, size

    def _left(self, item: Encoded, pts: int) -> None:
        self._newest = (pts, item.captured_s)
        self._on_sent(item)

    async def _report(self) -> None:
        """Report the RTP time of now in capture time, so that encoding delay causes no skew."""
        while True:
            await asyncio.sleep(_REPORT_S * (0.5 + random.random()))
            if self._newest is None:
                continue
            pts, captured_s = self._newest
            now_s = self._now_s()
            ntp = rtp.ntp_time(self._wall_ms() / 1000)
            now_pts = pts + round((now_s - captured_s) * self._rate_hz)
            report = rtp.sender_report(
                ssrc=self.ssrc,
                ntp=ntp,
                timestamp=(self.origin + now_pts) % UINT32,
                packets=self._packets,
                octets=self._octets,
                cname=self._cname,
            )
            self._reported.sent(ntp, now_s)
            await self.put(report)
