"""Counts and numbers everything that one peer sends, and matches it with the feedback."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, Protocol
from weakref import WeakSet

import structlog

from wax.congestion.wire_cost import UDP_IP_BYTES
from wax.errors import ProtocolError
from wax.rtc import private, rtcp, twcc_feedback
from wax.rtc.in_flight import MOST_DELIVERIES, InFlight

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aiortc import RTCDtlsTransport

    from wax.congestion.control import CongestionControl

_LOG = structlog.get_logger(__name__)


class Stream(Protocol):
    """One of our streams; its methods must not raise."""

    @property
    def ssrc(self) -> int: ...

    def handle_report(self, report: rtcp.ReportBlock) -> None: ...

    def handle_nack(self, numbers: Sequence[int]) -> None:
        """Handle a request to retransmit packets."""
        ...

    def handle_keyframe_request(self) -> None: ...


class TransportTap:
    """Sits between the senders of a peer and their common transport."""

    def __init__(
        self,
        congestion: CongestionControl,
        now_s: Callable[[], float],
        on_refused: Callable[[], None],
    ) -> None:
        """`on_refused` is called for invalid feedback."""
        self.congestion = congestion
        self._on_refused = on_refused
        self._now_s = now_s
        self._transmissions = InFlight()
        self._streams: dict[int, Stream] = {}
        self._transports: WeakSet[RTCDtlsTransport] = WeakSet()

    def attach(self, transport: RTCDtlsTransport) -> None:
        """Count what this transport sends and handle its RTCP; safe to repeat."""
        if transport not in self._transports:
            self._transports.add(transport)
            private.on_datagram(transport, self._count_dtls)
            private.on_rtcp(transport, self._handle_rtcp)

    def add(self, stream: Stream) -> None:
        """Hand a stream the browser's reports and requests; safe to repeat."""
        self._streams[stream.ssrc] = stream

    def remove(self, stream: Stream) -> None:
        """Hand a stream nothing more; safe to repeat."""
        self._streams.pop(stream.ssrc, None)

    def forget(self) -> None:
        """Expect no feedback about packets in flight: they took another path."""
        self._transmissions.forget()

    def number_packet(
        self,
        size_bytes: int,
        now_s: float,
        *,
        kind: Literal["audio", "video", "repeat"],
        train: int | None,
    ) -> int | None:
        """Return the transport-wide sequence number for a packet of about this size, or None.

        Call it for each packet of a stream with feedback, just before it leaves.
        """
        if not self.congestion.requests_feedback(train, now_s):
            return None
        return self._transmissions.sent(now_s, size_bytes=size_bytes, kind=kind, train=train)

    def count_media(self, size_bytes: int, now_s: float, *, has_feedback: bool) -> None:
        """Count a datagram of media; `has_feedback` says whether its stream has any."""
        self.congestion.sent(
            size_bytes + UDP_IP_BYTES, now_s, is_media=True, has_feedback=has_feedback
        )

    def free_in_s(self, now_s: float) -> float:
        """Return how long a picture has to wait in s; 0 to send it now."""
        return self.congestion.free_in_s(self._transmissions.oldest_unreported_s(now_s), now_s)

    def _count_dtls(self, datagram: bytes) -> None:
        """Count a datagram of DTLS, which carries the data channels."""
        self.congestion.sent(
            len(datagram) + UDP_IP_BYTES, self._now_s(), is_media=False, has_feedback=False
        )

    def _handle_rtcp(self, datagram: bytes) -> None:
        """Handle a datagram of the browser's RTCP."""
        heard = rtcp.read(datagram)
        if self.congestion.uses_feedback:
            self._handle_feedback(heard.feedback)
        for ssrc, report in heard.reports.items():
            if (stream := self._streams.get(ssrc)) is not None:
                stream.handle_report(report)
        for ssrc, numbers in heard.nacks.items():
            if (stream := self._streams.get(ssrc)) is not None:
                stream.handle_nack(numbers)
        for ssrc in heard.keyframes:
            if (stream := self._streams.get(ssrc)) is not None:
                stream.handle_keyframe_request()

    def _handle_feedback(self, found: Sequence[bytes]) -> None:
        now_s = self._now_s()
        left = MOST_DELIVERIES
        for one in found:
            try:
                deliveries = self._transmissions.reported(twcc_feedback.parse(one), now_s)[-left:]
            except ProtocolError as error:
                _LOG.debug("feedback refused", error=str(error))
                self._on_refused()
                continue
            if deliveries:  # none in a repeated feedback
                self.congestion.delivered(deliveries, now_s)
            left -= len(deliveries)
            if not left:
                break
