"""One stream to one browser: a replacement for aiortc's RTCRtpSender that reads from a lane.

aiortc's own encodes for each viewer, has no pacing and no transport-wide numbers, retransmits
without limit, reports the time of sending as that of capture, and loses keyframe requests. This one
sends what was encoded for everybody, and asks congestion control before a picture leaves. It is a
state machine with one timer: a coroutine per packet would cost as much as the packet.
"""

from __future__ import annotations

import asyncio
import random
from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Final, Literal

import structlog

from wax.clock import UNIX_ZERO_S
from wax.congestion.wire_cost import UDP_IP_BYTES
from wax.rtc import private, rtp
from wax.rtc.egress import Egress
from wax.rtc.receiver_reports import SenderReportTimes

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aiortc import RTCRtpSender
    from aiortc.rtcrtpparameters import RTCRtpSendParameters

    from wax.clock import Clock
    from wax.rtc.lane import Encoded, Lane
    from wax.rtc.rtcp import ReportBlock
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
_APART_S: Final = 1e-6
"""Assumed between the packets of one call: the estimator tells them apart by their times."""


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


def wire_bytes(packet: rtp.Packet) -> int:
    """Return about the size of the packet's datagram, all headers included."""
    return len(packet.head) + len(packet.payload) + _RTP_BYTES + _SRTP_BYTES + UDP_IP_BYTES


class Sender(private.SenderInPlace):
    """The common part of the sound and picture senders."""

    kind: ClassVar[Literal["audio", "video"]]

    def __init__(self, context: SenderContext, lane: Lane) -> None:
        # A browser would delay sound for a late picture in the same stream; here the sound is the
        # master and only sync/ couples them.
        super().__init__(context.stock, f"wax-{self.kind}")
        self.origin = random.getrandbits(32)
        """The RTP time of media time zero, random by RFC 3550, 5.1."""
        self.failed = False
        self.heard_s: float | None = None
        """When the other end last reported on this stream (RFC 3550, 6.4)."""
        self.round_trip_s: float | None = None
        """By the newest of those reports; None before the first."""
        self._source = lane
        self._tap = context.tap
        self._now_s = context.clock.now_s
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
        self._egress: Egress | None = None
        self._has_news = self._is_working = False
        self._timer: asyncio.TimerHandle | None = None
        self._report_timer: asyncio.TimerHandle | None = None

    # --- the transceiver's interface -------------------------------------------------------

    def start_sending(self, parameters: RTCRtpSendParameters) -> None:
        self._tap.attach(self.transport)
        self._tap.add(self)
        numbers = {one.uri: one.id for one in parameters.headerExtensions}
        self._ids = rtp.ExtensionIds(
            transport_sequence=numbers.get(rtp.TRANSPORT_SEQUENCE),
            playout_delay=numbers.get(rtp.PLAYOUT_DELAY),
            capture_time=numbers.get(rtp.CAPTURE_TIME),
        )
        has_feedback = self._ids.transport_sequence is not None
        self._tap.congestion.negotiated(has_feedback=has_feedback, kind=self.kind)
        self._cname = parameters.rtcp.cname or ""
        self._payload_type = parameters.codecs[0].payloadType or 0
        extra = next((c for c in parameters.codecs if c.name.lower() == self._extra_name), None)
        self._extra_payload_type = None if extra is None else extra.payloadType
        self._egress = Egress(private.DtlsMediaTransport(self.transport))
        self._source.set_listener(self._wake)
        self._plan_report()
        self._wake()

    def stop_sending(self) -> None:
        self._egress = None
        self._tap.remove(self)
        self._source.set_listener(_nobody)
        for timer in (self._timer, self._report_timer):
            if timer is not None:
                timer.cancel()

    # --- what the browser sends (transport_tap.Stream) -------------------------------------

    def handle_report(self, report: ReportBlock) -> None:
        now_s = self._now_s()
        self._tap.congestion.lost(report.fraction_lost / 256, now_s, self.kind)
        self.heard_s = now_s
        trip_s = self._reported.round_trip_s(report.last_report, report.delay, now_s)
        if trip_s is not None:
            self.round_trip_s = trip_s
            self._tap.congestion.round_trip(trip_s, now_s)

    def handle_nack(self, numbers: Sequence[int]) -> None:
        """Do nothing: a retransmission would come too late."""

    def handle_keyframe_request(self) -> None:
        """Do nothing: sound has no keyframes."""

    # --- what the two kinds do differently -------------------------------------------------

    _extra_name: ClassVar[str]
    """The codec's companion format: retransmissions or redundancy."""

    @abstractmethod
    def _work(self) -> float | None:
        """Send what may leave now; return the seconds until the next call, None to wait."""

    # --- sending ---------------------------------------------------------------------------

    def _wake(self) -> None:
        """Send what is available, including what arrives meanwhile; never raises.

        Counting what was sent may change what is sent next, so this may be called recursively. A
        timer that is already set is kept.
        """
        self._has_news = True
        if self._is_working or self._timer is not None:
            return
        self._is_working = True
        try:
            wait_s: float | None = None
            while self._has_news and self._egress is not None:
                self._has_news = False
                wait_s = self._work()
            if wait_s is not None and self._egress is not None:
                self._timer = asyncio.get_running_loop().call_later(wait_s, self._resume)
        except Exception as error:
            self._fail(error)
        finally:
            self._is_working = False

    def _resume(self) -> None:
        self._timer = None
        self._wake()

    def _fail(self, error: Exception) -> None:
        """Stop for good; whoever checks `failed` closes the peer."""
        if not isinstance(error, ConnectionError):  # then the peer is closing
            _LOG.exception("a sender failed", kind=self.kind)
        self.failed = True
        self.stop_sending()

    @property
    def newest_captured_s(self) -> float | None:
        """Capture time of the newest content sent, None before the first."""
        return None if self._newest is None else self._newest[1]

    def _captured_ntp(self, item: Encoded) -> int | None:
        """Return the item's capture time, None if the extension for it was not negotiated."""
        if self._ids.capture_time is None:
            return None
        return rtp.ntp_time(UNIX_ZERO_S + item.captured_s)

    def _next_number(self) -> int:
        """Return the sequence number of the stream's next packet."""
        number = self._sequence_number
        self._sequence_number = (number + 1) % UINT16
        return number

    def _send_packets(
        self, packets: Sequence[rtp.Packet], now_s: float, *, train: int | None = None
    ) -> None:
        """Send packets of the stream together."""
        self._transmit(packets, now_s, kind=self.kind, train=train)
        self._packets += len(packets)
        self._octets += sum([len(one.head) + len(one.payload) for one in packets])

    def _transmit(
        self,
        packets: Sequence[rtp.Packet],
        now_s: float,
        *,
        kind: Literal["audio", "video", "repeat"],
        train: int | None = None,
    ) -> None:
        ready = []
        has_feedback = self._ids.transport_sequence is not None
        for index, packet in enumerate(packets):
            number = None
            if has_feedback:
                sent_s = now_s + index * _APART_S
                number = self._tap.number_packet(wire_bytes(packet), sent_s, kind=kind, train=train)
            extensions = rtp.extension_block(
                self._ids,
                transport_sequence=number,
                playout_delay=packet.playout_delay,
                captured_ntp=packet.captured_ntp,
            )
            ready.append(packet.to_bytes(extensions))
        self._send_datagrams(ready, now_s, has_feedback=has_feedback)

    def _send_datagrams(
        self, ready: Sequence[bytes], now_s: float, *, has_feedback: bool, is_rtcp: bool = False
    ) -> None:
        if self._egress is None:
            raise ConnectionError("the sender has ended")
        for index, size in enumerate(self._egress.send(ready, is_rtcp=is_rtcp)):
            self._tap.count_media(size, now_s + index * _APART_S, has_feedback=has_feedback)

    def _note_sent(self, item: Encoded) -> None:
        self._newest = (item.pts, item.captured_s)
        self._on_sent(item)

    def _plan_report(self) -> None:
        wait_s = _REPORT_S * (0.5 + random.random())
        self._report_timer = asyncio.get_running_loop().call_later(wait_s, self._report)

    def _report(self) -> None:
        """Report which RTP time is being captured now, so that encoding delay causes no skew."""
        try:
            if self._newest is not None:
                self._send_report(*self._newest)
        except Exception as error:
            self._fail(error)
        else:
            self._plan_report()

    def _send_report(self, pts: int, captured_s: float) -> None:
        now_s = self._now_s()
        ntp = rtp.ntp_time(UNIX_ZERO_S + now_s)
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
        self._send_datagrams([report], now_s, has_feedback=False, is_rtcp=True)


def _nobody() -> None: ...
