"""The server's only place that touches private parts of aiortc and aioice, and why each is needed.

Pinned in pyproject.toml to the minor versions that this was read against; `check` fails with a
readable sentence when a new version has moved something.
"""

from __future__ import annotations

import asyncio
import contextlib
import copy
from abc import ABC, abstractmethod
from collections import deque
from typing import TYPE_CHECKING, Any, Final, cast

import aioice.ice
from aiortc import RTCDtlsTransport, RTCIceTransport, RTCRtpSender, RTCSctpTransport
from aiortc.rtcrtpparameters import (
    ParametersDict,
    RTCRtcpFeedback,
    RTCRtpCodecParameters,
    RTCRtpHeaderExtensionParameters,
)
from aiortc.rtcrtptransceiver import RTCRtpTransceiver
from aiortc.sdp import SessionDescription

from wax.errors import StartError

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from aiortc.rtcrtpparameters import RTCRtpSendParameters
    from aiortc.rtp import AnyRtcpPacket

_FOR_EVER: Final = 10**9
_SENDER: Final = "_RTCRtpTransceiver__sender"
_FEEDBACK: Final = RTCRtcpFeedback(type="transport-cc")
_RED: Final = "audio/red"
_BURST: Final = 4
_BURST_S: Final = 0.05
"""So many packets within this time belong to one message, whose sender may send no more before
they are acknowledged. Set-points are farther apart."""


def check() -> None:
    """Raise `StartError` naming each private part that this version no longer has."""

    def sets(owner: type, name: str) -> bool:
        return name in owner.__init__.__code__.co_names  # type: ignore[misc]  # of that very class

    missing = [
        name
        for name, there in (
            ("aioice.ice.CONSENT_FAILURES", hasattr(aioice.ice, "CONSENT_FAILURES")),
            ("aioice.ice.get_host_addresses", hasattr(aioice.ice, "get_host_addresses")),
            ("RTCRtpTransceiver.__sender", sets(RTCRtpTransceiver, _SENDER)),
            ("RTCRtpTransceiver._codecs", sets(RTCRtpTransceiver, "_codecs")),
            ("RTCRtpTransceiver._headerExtensions", sets(RTCRtpTransceiver, "_headerExtensions")),
            ("RTCRtpSender._ssrc", sets(RTCRtpSender, "_ssrc")),
            ("RTCRtpSender._rtx_ssrc", sets(RTCRtpSender, "_rtx_ssrc")),
            ("RTCRtpSender._track_id", "_track_id" in RTCRtpSender.replaceTrack.__code__.co_names),
            ("RTCDtlsTransport._send_rtp", hasattr(RTCDtlsTransport, "_send_rtp")),
            ("RTCDtlsTransport._handle_rtcp_data", hasattr(RTCDtlsTransport, "_handle_rtcp_data")),
            (
                "RTCDtlsTransport._register_rtp_sender",
                hasattr(RTCDtlsTransport, "_register_rtp_sender"),
            ),
            (
                "RTCDtlsTransport._unregister_rtp_sender",
                hasattr(RTCDtlsTransport, "_unregister_rtp_sender"),
            ),
            ("RTCIceTransport._send", sets(RTCIceTransport, "_send")),
            ("RTCSctpTransport._send_sack", hasattr(RTCSctpTransport, "_send_sack")),
        )
        if not there
    ]
    if missing:
        raise StartError(
            "this version of aiortc or aioice is not the one WAX was built for "
            f"({', '.join(missing)} moved); install the versions of requirements.lock"
        )


def install() -> None:
    """Mend aioice for the whole process; call once, before the first peer. Safe to repeat."""
    check()
    # Consent (RFC 7675) waits 0.5 s for an answer and closes a working connection whose round
    # trips take longer, yet notices a vanished browser after half a minute. Liveness is our
    # own heartbeat (rtc/link.py); consent must only never give up.
    aioice.ice.CONSENT_FAILURES = _FOR_EVER
    aioice.ice.get_host_addresses = _host_addresses


def _host_addresses(use_ipv4: bool, use_ipv6: bool) -> list[str]:
    """Offer 127.0.0.1 where there is nothing else: a machine with only a loopback interface."""
    return _found_addresses(use_ipv4, use_ipv6) or (["127.0.0.1"] if use_ipv4 else [])


_found_addresses = aioice.ice.get_host_addresses


class SenderInPlace(ABC):
    """Stands in a transceiver where aiortc has put `stock`, whose identity it takes over.

    It has what aiortc's peers read and call on a sender, under their names; a subclass does the
    work under names of its own. `stream` is the media stream that the track belongs to (`a=msid`,
    RFC 8830).
    """

    def __init__(self, stock: RTCRtpSender, stream: str) -> None:
        self._ssrc = stock._ssrc
        self._rtx_ssrc = stock._rtx_ssrc
        self._track_id = stock._track_id
        self._stream_id = stream
        self._enabled = True
        self._transport = stock.transport
        self._is_sending = False
        self.track = None

    @property
    def ssrc(self) -> int:
        return self._ssrc

    @property
    def rtx_ssrc(self) -> int:
        """The SSRC of repeats (RFC 4588)."""
        return self._rtx_ssrc

    @property
    def transport(self) -> RTCDtlsTransport:
        return self._transport

    def setTransport(self, transport: RTCDtlsTransport) -> None:  # noqa: N802  # aiortc's
        self._transport = transport

    async def send(self, parameters: RTCRtpSendParameters) -> None:
        """Begin; `parameters` is what was negotiated. Safe to repeat."""
        if not self._is_sending:
            self._is_sending = True
            self._transport._register_rtp_sender(self, parameters)
            self.begin(parameters)

    async def stop(self) -> None:
        """End for good; safe to call twice."""
        if self._is_sending:
            self._is_sending = False
            self._transport._unregister_rtp_sender(self)
            await self.end()

    async def _handle_rtcp_packet(self, packet: AnyRtcpPacket) -> None:
        self.heard(packet)

    async def put(self, data: bytes) -> None:
        """Put one RTP or RTCP packet on the wire; raises ConnectionError once that is closed."""
        await self._transport._send_rtp(data)

    @abstractmethod
    def begin(self, parameters: RTCRtpSendParameters) -> None:
        """Begin to send as was negotiated."""

    @abstractmethod
    async def end(self) -> None:
        """Send no more."""

    @abstractmethod
    def heard(self, packet: AnyRtcpPacket) -> None:
        """Take what the browser tells of this stream or asks for it."""


def put_sender(transceiver: RTCRtpTransceiver, sender: SenderInPlace) -> None:
    """Let this transceiver send by our sender: aiortc has no way to bring one's own."""
    setattr(transceiver, _SENDER, sender)


def widen(transceiver: RTCRtpTransceiver, offer: str, extensions: Collection[str]) -> None:
    """Agree to what the browser offers and aiortc does not know; between offer and answer.

    The header extensions with these URIs, feedback for the whole transport, and redundant sound
    (RFC 2198) of the codec that was chosen.
    """
    media = next(
        (m for m in SessionDescription.parse(offer).media if m.rtp.muxId == transceiver.mid), None
    )
    if media is None or not transceiver._codecs:
        return
    transceiver._headerExtensions = [
        *transceiver._headerExtensions,
        *(
            RTCRtpHeaderExtensionParameters(id=one.id, uri=one.uri)
            for one in media.rtp.headerExtensions
            if one.uri in extensions
        ),
    ]
    chosen = transceiver._codecs[0]
    for offered in media.rtp.codecs:
        if offered.payloadType == chosen.payloadType and _FEEDBACK in offered.rtcpFeedback:
            chosen.rtcpFeedback = [*chosen.rtcpFeedback, _FEEDBACK]
        if _is_red_of(offered, chosen):
            transceiver._codecs = [*transceiver._codecs, copy.deepcopy(offered)]


def _is_red_of(offered: RTCRtpCodecParameters, chosen: RTCRtpCodecParameters) -> bool:
    wanted = cast("ParametersDict", {f"{chosen.payloadType}/{chosen.payloadType}": None})
    return (
        offered.mimeType.lower() == _RED
        and offered.clockRate == chosen.clockRate
        and offered.parameters == wanted
    )


def on_datagram(transport: RTCDtlsTransport, callback: Callable[[bytes], None]) -> None:
    """Call back with each datagram that leaves, the data channels' and RTCP's too."""
    ice = transport.transport
    send = ice._send

    async def counted(data: bytes) -> None:
        callback(data)
        await send(data)

    ice._send = counted


def on_rtcp(transport: RTCDtlsTransport, callback: Callable[[bytes], None]) -> None:
    """Call back with all RTCP that comes: aiortc misreads transport-wide feedback."""
    handle = transport._handle_rtcp_data

    async def heard(data: bytes) -> None:
        callback(data)
        await handle(data)

    transport._handle_rtcp_data = heard  # type: ignore[method-assign]  # see above


def delay_acknowledgements(sctp: RTCSctpTransport, delay_s: float) -> None:
    """Acknowledge together what comes within `delay_s` (RFC 9260, 6.2; 200 ms at most).

    aiortc acknowledges each message at once, in a datagram of 93 bytes: at twenty set-points a
    second that is a third of a modem line. A message of many packets is acknowledged as it comes.
    """
    acknowledge = sctp._send_sack
    waiting: list[asyncio.TimerHandle] = []
    under_way: set[asyncio.Task[Any]] = set()
    came_s: deque[float] = deque(maxlen=_BURST)

    async def now() -> None:
        came_s.clear()
        while waiting:
            waiting.pop().cancel()
        with contextlib.suppress(ConnectionError):  # closed in between: nobody is left to tell
            await acknowledge()

    def due() -> None:
        task = asyncio.ensure_future(now())
        under_way.add(task)
        task.add_done_callback(under_way.discard)

    async def later() -> None:
        loop = asyncio.get_running_loop()
        came_s.append(loop.time())
        if len(came_s) == _BURST and came_s[-1] - came_s[0] < _BURST_S:
            await now()
        elif not waiting:
            waiting.append(loop.call_later(delay_s, due))

    sctp._send_sack = later  # type: ignore[method-assign]  # see above
