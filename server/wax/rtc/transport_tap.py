"""Counts and numbers everything that one peer sends, and matches it with the feedback."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal
from weakref import WeakSet

import structlog

from wax.congestion.delivery import UDP_IP_BYTES
from wax.errors import ProtocolError
from wax.rtc import feedback, private
from wax.rtc.in_flight import InFlight

if TYPE_CHECKING:
    from collections.abc import Callable

    from aiortc import RTCDtlsTransport

    from wax.congestion.control import CongestionControl

_LOG = structlog.get_logger(__name__)


class TransportTap:
    """Sits between the two senders of a peer and their common transport."""

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
        self._transports: WeakSet[RTCDtlsTransport] = WeakSet()
        self._marked_s: float | None = None
        self._has_feedback = False

    def join(self, transport: RTCDtlsTransport) -> None:
        """Count what this transport sends and handle the feedback; safe to repeat."""
        if transport not in self._transports:
            self._transports.add(transport)
            private.on_datagram(transport, self._sent)
            private.on_rtcp(transport, self._told)

    def mark(
        self, size_bytes: int, kind: Literal["audio", "video", "repeat"], train: int | None
    ) -> int | None:
        """Return the transport-wide sequence number for a packet of about this size, or None.

        To be called just before each packet of a stream with feedback is sent.
        """
        self._has_feedback = True
        now_s = self._now_s()
        if not self.congestion.requests_feedback(train, now_s):
            return None
        self._marked_s = now_s
        return self._transmissions.sent(now_s, size_bytes=size_bytes, kind=kind, train=train)

    def free_in_s(self, now_s: float) -> float:
        """Return how long a picture has to wait in s; 0 to send it now."""
        return self.congestion.free_in_s(self._transmissions.oldest_unreported_s(now_s), now_s)

    def _sent(self, datagram: bytes) -> None:
        # DTLS, and with it the data channels, has first bytes 20 to 63, RTP 128 to 191 (RFC 7983).
        is_media = datagram[0] > 127
        # A packet that was marked leaves before anything else can: it has one time, not two.
        now_s, self._marked_s = self._marked_s, None
        has_feedback, self._has_feedback = self._has_feedback, False
        self.congestion.sent(
            len(datagram) + UDP_IP_BYTES,
            self._now_s() if now_s is None else now_s,
            is_media=is_media,
            has_feedback=has_feedback,
        )

    def _told(self, rtcp: bytes) -> None:
        if not self.congestion.uses_feedback:
            return
        now_s = self._now_s()
        for one in feedback.find(rtcp):
            try:
                deliveries = self._transmissions.reported(feedback.parse(one), now_s)
            except ProtocolError as error:
                _LOG.debug("feedback refused", error=str(error))
                self._on_refused()
                continue
            self.congestion.delivered(deliveries, now_s)
