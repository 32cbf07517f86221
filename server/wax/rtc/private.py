"""The server's only module that touches private parts of aiortc and what it stands on, and why.

pyproject.toml pins the minor versions that this was written for; `check` fails with a readable
sentence if a new version has moved something.
"""

from __future__ import annotations

import asyncio
import contextlib
import copy
import struct
import time
from abc import ABC, abstractmethod
from bisect import insort
from collections import deque
from contextvars import ContextVar
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, cast

import aioice.candidate
import aioice.ice
import aioice.stun
import pylibsrtp
import structlog
from aiortc import (
    RTCDtlsTransport,
    RTCIceGatherer,
    RTCIceTransport,
    RTCPeerConnection,
    RTCRtpReceiver,
    RTCRtpSender,
    RTCSctpTransport,
    rtcdtlstransport,
    rtcicetransport,
    rtcsctptransport,
)
from aiortc.rtcrtpparameters import (
    ParametersDict,
    RTCRtcpFeedback,
    RTCRtpCodecParameters,
    RTCRtpHeaderExtensionParameters,
)
from aiortc.rtcrtptransceiver import RTCRtpTransceiver

from wax.errors import StartError
from wax.rtc import datagram

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Collection, Iterator, Sequence

    from aiortc.mediastreams import MediaStreamTrack
    from aiortc.rtcicetransport import RTCIceParameters
    from aiortc.rtcrtpparameters import RTCRtpReceiveParameters, RTCRtpSendParameters
    from aiortc.rtp import AnyRtcpPacket
    from aiortc.sdp import MediaDescription, SessionDescription

    from wax.edge.turnstile import Meter

_LOG = structlog.get_logger(__name__)

_FOR_EVER: Final = 10**9
_SENDER: Final = "_RTCRtpTransceiver__sender"
_RECEIVER: Final = "_RTCRtpTransceiver__receiver"
_RATE: Final = "_RTCRtpReceiver__remote_bitrate_estimator"
_OFFER: Final = "_RTCPeerConnection__pendingRemoteDescription"
_ANSWER: Final = "_RTCPeerConnection__currentRemoteDescription"
_FEEDBACK: Final = RTCRtcpFeedback(type="transport-cc")
_RED: Final = "audio/red"
_BURST: Final = 4
_BURST_S: Final = 0.05
"""This many packets within this time belong to one message, whose sender may be waiting for the
acknowledgement. Set-points are further apart."""
_MAX_WAITING: Final = 128
"""Datagrams that aiortc has not read yet, as on the one port."""
_COOKIE: Final = aioice.stun.COOKIE.to_bytes(4, "big")
_MAX_WAITING_BYTES: Final = 65_536
_MAX_FRAGMENTS: Final = 64
"""Fragments of incomplete messages: those of the longest message, 64 KiB, and a few more."""
_MAX_AHEAD: Final = 256
"""Chunks beyond a missing one: as many gaps as fit into an acknowledgement of one datagram."""
_MAX_STREAMS: Final = 8
"""A page has two data channels."""
_MAX_CHUNKS: Final = 32
"""Of one packet: a message of the page fills a tenth of one. The rest counts as lost."""
_MAX_INITS: Final = 8
"""Before there is an association: as often as it is tried (RFC 9260, Max.Init.Retransmits)."""
_ANSWERED: Final = frozenset((1, 2, 4, 7, 10, 130))
"""INIT, INIT ACK, HEARTBEAT, SHUTDOWN, COOKIE ECHO and RE-CONFIG get an answer at once."""
_REPEATED: Final = frozenset((0,))
"""Only DATA comes more than once in a packet."""
_RECONFIG_BYTES: Final = {13: 12 + 2 * _MAX_STREAMS, 16: 16}
"""The parameters of browsers (RFC 6525, 4.1 and 4.4), without header: a request that resets
streams, and an answer to ours."""
_SACK_BYTES: Final = 28
"""A packet with a SACK that has neither gaps nor duplicates."""
_MAX_SOURCES: Final = 32
"""Of one browser: a few for its reports, and one for a voice."""
_WHOLE: Final = 0b11
"""The flags of a chunk that begins a message and ends it (RFC 9260, 3.3.1)."""
_UINT32: Final = 2**32


def check() -> None:
    """Raise `StartError` with each private part that this version lacks."""

    def sets(owner: type, name: str) -> bool:
        return name in owner.__init__.__code__.co_names  # type: ignore[misc]  # of that very class

    missing = [
        name
        for name, there in (
            ("aioice.ice.CONSENT_FAILURES", hasattr(aioice.ice, "CONSENT_FAILURES")),
            ("aioice.ice.get_host_addresses", hasattr(aioice.ice, "get_host_addresses")),
            *(
                (f"aioice.stun.{name}", hasattr(aioice.stun, name))
                for name in ("COOKIE", "Class", "Message", "Method", "parse_message")
            ),
            *(
                (f"aioice.candidate.{name}", hasattr(aioice.candidate, name))
                for name in ("candidate_foundation", "candidate_priority")
            ),
            ("rtcicetransport.Connection", hasattr(rtcicetransport, "Connection")),
            ("RTCIceGatherer._connection", sets(RTCIceGatherer, "_connection")),
            (
                "RTCIceGatherer.getLocalParameters",
                hasattr(RTCIceGatherer, "getLocalParameters"),
            ),
            (
                "aioice.ice.Connection.data_received",
                hasattr(aioice.ice.Connection, "data_received"),
            ),
            ("aioice.ice.Connection._queue", sets(aioice.ice.Connection, "_queue")),
            (
                "aioice.ice.StunProtocol.datagram_received",
                "datagram_received" in vars(aioice.ice.StunProtocol),
            ),
            ("RTCDtlsTransport._recv_next", hasattr(RTCDtlsTransport, "_recv_next")),
            ("RTCIceTransport._recv", sets(RTCIceTransport, "_recv")),
            (
                "RTCPeerConnection.__pendingRemoteDescription",
                sets(RTCPeerConnection, _OFFER),
            ),
            (
                "RTCPeerConnection.__currentRemoteDescription",
                sets(RTCPeerConnection, _ANSWER),
            ),
            ("RTCRtpTransceiver.__sender", sets(RTCRtpTransceiver, _SENDER)),
            ("RTCRtpTransceiver.__receiver", sets(RTCRtpTransceiver, _RECEIVER)),
            ("RTCRtpReceiver._track", sets(RTCRtpReceiver, "_track")),
            ("RTCDtlsTransport._handle_rtp_data", hasattr(RTCDtlsTransport, "_handle_rtp_data")),
            ("RTCRtpReceiver.__remote_bitrate_estimator", sets(RTCRtpReceiver, _RATE)),
            ("RTCRtpTransceiver._codecs", sets(RTCRtpTransceiver, "_codecs")),
            ("RTCRtpTransceiver._headerExtensions", sets(RTCRtpTransceiver, "_headerExtensions")),
            ("RTCRtpSender._ssrc", sets(RTCRtpSender, "_ssrc")),
            ("RTCRtpSender._rtx_ssrc", sets(RTCRtpSender, "_rtx_ssrc")),
            ("RTCRtpSender._track_id", "_track_id" in RTCRtpSender.replaceTrack.__code__.co_names),
            ("RTCDtlsTransport._state", sets(RTCDtlsTransport, "_state")),
            ("RTCDtlsTransport._tx_srtp", sets(RTCDtlsTransport, "_tx_srtp")),
            ("RTCIceTransport._connection", sets(RTCIceTransport, "_connection")),
            ("aioice.ice.Connection._nominated", sets(aioice.ice.Connection, "_nominated")),
            ("pylibsrtp.Session._srtp", sets(pylibsrtp.Session, "_srtp")),
            *(
                (f"pylibsrtp.{name}", hasattr(pylibsrtp, name))
                for name in ("ffi", "lib", "_srtp_assert")
            ),
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
            *(
                (f"RTCSctpTransport.{name}", hasattr(RTCSctpTransport, name))
                for name in (
                    "_handle_data",
                    "_mark_received",
                    "_receive_chunk",
                    "_send_chunk",
                    "_send_sack",
                    "_set_state",
                )
            ),
            (
                "rtcsctptransport.InboundStream.add_chunk",
                hasattr(rtcsctptransport.InboundStream, "add_chunk"),
            ),
            *(
                (f"RTCSctpTransport.{name}", sets(RTCSctpTransport, name))
                for name in (
                    "_advertised_rwnd",
                    "_data_channel_queue",
                    "_data_channels",
                    "_inbound_streams",
                    "_last_received_tsn",
                    "_local_tsn",
                    "_local_verification_tag",
                    "_sack_duplicates",
                    "_sack_misordered",
                    "_sack_needed",
                )
            ),
            *(
                (f"rtcsctptransport.{name}", hasattr(rtcsctptransport, name))
                for name in (
                    "CHUNK_TYPES",
                    "DataChunk",
                    "ForwardTsnChunk",
                    "InitChunk",
                    "LOCAL_MAX_MESSAGE_SIZE",
                    "ReconfigChunk",
                    "SackChunk",
                    "ShutdownChunk",
                    "crc32c",
                    "decode_params",
                )
            ),
        )
        if not there
    ]
    if missing:
        raise StartError(
            "this version of aiortc or aioice is not the one WAX was built for "
            f"({', '.join(missing)} moved); install the versions of requirements.lock"
        )


def install() -> None:
    """Patch aioice and aiortc for the whole process, before the first peer; safe to repeat."""
    check()
    # Consent (RFC 7675) waits 0.5 s for an answer and closes a working connection whose round
    # trips take longer, yet notices a vanished browser only after half a minute. Our own heartbeat
    # (`link_monitor`) checks liveness, so consent must never give up.
    aioice.ice.CONSENT_FAILURES = _FOR_EVER
    aioice.ice.get_host_addresses = _host_addresses
    aioice.ice.Connection.data_received = _data_received  # type: ignore[assignment,method-assign]
    cast("Any", aioice.ice.StunProtocol).datagram_received = _datagram_received
    cast("Any", RTCDtlsTransport)._recv_next = _receive_next
    aioice.stun.parse_message = _parsed_stun
    cast("Any", rtcicetransport).Connection = _connection
    cast("Any", RTCIceGatherer).getLocalParameters = _local_parameters
    rtcsctptransport.decode_params = _decoded_params
    cast("Any", rtcsctptransport.InboundStream).add_chunk = _add_chunk
    # The limit in our answer, so that the browser sends nothing longer.
    rtcsctptransport.LOCAL_MAX_MESSAGE_SIZE = _MAX_WAITING_BYTES


@dataclass(frozen=True, slots=True)
class Reach:
    """How one peer reaches the network.

    `connect` makes what it uses in place of aioice's connection; without it aioice gathers on
    `addresses`, without which on all of this machine.
    """

    connect: Callable[[], Any] | None = None
    addresses: Callable[[], list[str]] | None = None


_reach: ContextVar[Reach | None] = ContextVar("reach", default=None)


@contextlib.contextmanager
def reached_by(reach: Reach) -> Iterator[None]:
    """Make the peers inside reach the network so.

    It must cover the constructor, and until the answer is made: aiortc makes a connection for each
    section of either, and gathers at the end.
    """
    token = _reach.set(reach)
    try:
        yield
    finally:
        _reach.reset(token)


def _connection(**options: Any) -> Any:
    reach = _reach.get()
    if reach is None or reach.connect is None:
        return _make_connection(**options)
    return reach.connect()


_make_connection = aioice.ice.Connection


def _local_parameters(gatherer: RTCIceGatherer) -> RTCIceParameters:
    """Say of a connection that only answers that it does (``a=ice-lite``)."""
    parameters = _find_local_parameters(gatherer)
    parameters.iceLite = getattr(gatherer._connection, "is_lite", False)
    return parameters


_find_local_parameters = RTCIceGatherer.getLocalParameters


def _host_addresses(use_ipv4: bool, use_ipv6: bool) -> list[str]:
    """Offer the addresses that were chosen, and 127.0.0.1 on a machine with only loopback."""
    reach = _reach.get()
    if reach is not None and reach.addresses is not None:
        return [
            address for address in reach.addresses() if (use_ipv6 if ":" in address else use_ipv4)
        ]
    return _found_addresses(use_ipv4, use_ipv6) or (["127.0.0.1"] if use_ipv4 else [])


_found_addresses = aioice.ice.get_host_addresses


class _Guard:
    """What is received by one ICE transport, without what nobody genuine can have sent."""

    def __init__(self, receive: Callable[[], Awaitable[bytes]]) -> None:
        self._receive = receive
        self.taken = 0
        self.sources: set[bytes] = set()
        """SSRCs that had the keys: libsrtp keeps a state of each for ever."""

    async def __call__(self) -> bytes:
        while not self._may_pass(data := await self._receive()):
            pass
        self.taken += 1
        return data

    def _may_pass(self, data: bytes) -> bool:
        if not datagram.is_plausible(data):
            return False
        source = datagram.source(data)
        return source is None or source in self.sources or len(self.sources) < _MAX_SOURCES


def _note_source(dtls: RTCDtlsTransport, source: bytes) -> None:
    guard: Any = dtls.transport._recv
    if isinstance(guard, _Guard):
        guard.sources.add(source)


async def _receive_next(dtls: RTCDtlsTransport) -> None:
    """Handle one datagram, whose sender need not be who it says: so it may end nothing.

    What has been authenticated is handled by functions of our own, which do not raise.
    """
    ice: Any = dtls.transport
    if not isinstance(ice._recv, _Guard):
        ice._recv = _Guard(ice._recv)
    before = ice._recv.taken
    try:
        await _take_next(dtls)
    except ConnectionError:
        raise
    except Exception as error:
        if ice._recv.taken == before:
            raise  # nothing came, so that it would be raised for ever
        _LOG.info("a datagram was not understood", error=repr(error))


_take_next = RTCDtlsTransport._recv_next


def _data_received(connection: aioice.ice.Connection, data: bytes, component: int) -> None:
    """Keep so many that wait, the newest, where aioice keeps all."""
    if connection._queue.qsize() >= _MAX_WAITING:
        connection._queue.get_nowait()
    _take_data(connection, data, component)


_take_data = aioice.ice.Connection.data_received


def _datagram_received(
    protocol: aioice.ice.StunProtocol, data: bytes, address: tuple[Any, ...]
) -> None:
    """Charge the peer for checks, which aioice answers at once; all else is charged when read."""
    meter: Meter | None = getattr(protocol.receiver, "meter", None)
    if meter is None or data[4:8] != _COOKIE:
        _take_datagram(protocol, data, address)
    elif meter.is_open:
        began_s = time.thread_time()
        _take_datagram(protocol, data, address)
        meter.charge(began_s)


_take_datagram = aioice.ice.StunProtocol.datagram_received


def _parsed_stun(data: bytes) -> aioice.stun.Message:
    """Refuse attributes of a wrong length with the one error that aioice expects of itself.

    And what is longer than any frame, since each attribute is made into an object.
    """
    if len(data) > datagram.MAX_BYTES:
        raise ValueError("a STUN message that is longer than a datagram")
    try:
        return _parse_stun(data)
    except (struct.error, IndexError) as error:
        raise ValueError(f"a STUN attribute of a wrong length: {error}") from error


_parse_stun = aioice.stun.parse_message


def _decoded_params(body: bytes) -> list[tuple[int, bytes]]:
    """Refuse a parameter of length zero (RFC 9260, 3.2.1), on which aiortc loops for ever."""
    at = 0
    while at <= len(body) - 4:
        length = int.from_bytes(body[at + 2 : at + 4])
        if length < 4:
            raise ValueError("an SCTP parameter that is shorter than its header")
        at += length + -length % 4
    return _decode_params(body)


_decode_params = rtcsctptransport.decode_params


class SenderInPlace(ABC):
    """Replaces aiortc's sender `stock` in a transceiver and takes over its identity.

    It has the attributes and methods that aiortc uses on a sender; subclasses do the work under
    other names. `stream` is the media stream of the track (`a=msid`, RFC 8830).
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
        """The SSRC of retransmissions (RFC 4588)."""
        return self._rtx_ssrc

    @property
    def transport(self) -> RTCDtlsTransport:
        return self._transport

    def setTransport(self, transport: RTCDtlsTransport) -> None:  # noqa: N802  # aiortc's
        self._transport = transport

    async def send(self, parameters: RTCRtpSendParameters) -> None:
        """Start with the negotiated `parameters`; safe to repeat."""
        if not self._is_sending:
            self._is_sending = True
            self._transport._register_rtp_sender(self, parameters)
            self.begin(parameters)

    async def stop(self) -> None:
        """End for good; safe to call twice."""
        if self._is_sending:
            self._is_sending = False
            self._transport._unregister_rtp_sender(self)
            self.end()

    async def _handle_rtcp_packet(self, packet: AnyRtcpPacket) -> None:
        del packet  # `on_rtcp` keeps all of it from aiortc

    @abstractmethod
    def begin(self, parameters: RTCRtpSendParameters) -> None:
        """Start sending as negotiated."""

    @abstractmethod
    def end(self) -> None:
        """Stop sending."""


class ReceiverInPlace(ABC):
    """Replaces aiortc's receiver `stock` in a transceiver.

    That one starts a thread for each stream, queues without bound and holds back 80 ms of sound.
    This has the attributes and methods that aiortc uses on a receiver. It gets all decrypted RTP of
    its transport, and aiortc none: its router would keep each SSRC that a page makes up.
    """

    def __init__(self, stock: RTCRtpReceiver) -> None:
        self._enabled = True
        self._track: MediaStreamTrack | None = None
        self._transport = stock.transport
        self._is_receiving = False

    @property
    def track(self) -> MediaStreamTrack | None:
        """What aiortc makes of the offer; nothing is ever put into it."""
        return self._track

    @property
    def transport(self) -> RTCDtlsTransport:
        return self._transport

    def setTransport(self, transport: RTCDtlsTransport) -> None:  # noqa: N802  # aiortc's
        self._transport = transport

    async def receive(self, parameters: RTCRtpReceiveParameters) -> None:
        """Start with the negotiated `parameters`; safe to repeat."""
        if not self._is_receiving:
            self._is_receiving = True
            self.begin(parameters)
            self._transport._handle_rtp_data = self._handle_rtp_data  # type: ignore[method-assign]  # see above

    async def stop(self) -> None:
        """End for good; safe to call twice."""
        self._is_receiving = False

    async def _handle_rtp_data(self, data: bytes, arrival_time_ms: int) -> None:
        del arrival_time_ms  # by another clock
        _note_source(self._transport, datagram.rtp_source(data))
        if self._is_receiving:
            self.heard(data)

    @abstractmethod
    def begin(self, parameters: RTCRtpReceiveParameters) -> None:
        """Start receiving as negotiated."""

    @abstractmethod
    def heard(self, packet: bytes) -> None:
        """Handle a packet of RTP, whatever is in it; must not raise."""


_srtp: Any = pylibsrtp


class DtlsMediaTransport:
    """The keys and the path of one DTLS transport (`egress.MediaTransport`)."""

    def __init__(self, dtls: RTCDtlsTransport) -> None:
        self._dtls = dtls
        self._size = _srtp.ffi.new("int *")
        self._memory: Any = None

    def protect(self, buffer: bytearray, at: int, size: int, *, is_rtcp: bool) -> int:
        """Protect a packet in place, for which pylibsrtp would copy it twice."""
        if self._dtls._state is not rtcdtlstransport.State.CONNECTED:
            raise ConnectionError("the DTLS transport is not connected")
        if self._memory is None:
            self._memory = _srtp.ffi.from_buffer(buffer)
        self._size[0] = size
        protect = _srtp.lib.srtp_protect_rtcp if is_rtcp else _srtp.lib.srtp_protect
        session = self._dtls._tx_srtp._srtp[0]
        _srtp._srtp_assert(protect(session, self._memory + at, self._size))
        protected: int = self._size[0]
        return protected

    def send(self, datagrams: memoryview, sizes: Sequence[int]) -> None:
        """Send by the shared port, or by the pair that aioice has nominated last."""
        connection: Any = self._dtls.transport._connection
        if hasattr(connection, "send_together"):
            connection.send_together(datagrams, sizes)
            return
        pair = connection._nominated.get(1)
        if pair is None:
            raise ConnectionError("there is no nominated pair")
        at = 0
        for size in sizes:
            # A relay has a transport of this kind, too.
            pair.protocol.transport.sendto(bytes(datagrams[at : at + size]), pair.remote_addr)
            at += size


def put_sender(transceiver: RTCRtpTransceiver, sender: SenderInPlace) -> None:
    """Use our sender in this transceiver; aiortc has no public way to do that.

    Nothing is received, so what estimates the rate of that (95 KiB) is not kept.
    """
    setattr(transceiver, _SENDER, sender)
    setattr(transceiver.receiver, _RATE, None)


def put_receiver(transceiver: RTCRtpTransceiver, receiver: ReceiverInPlace) -> None:
    """Use our receiver in this transceiver, after `put_sender`; see there."""
    setattr(transceiver, _RECEIVER, receiver)


def follow_bundle(transceiver: RTCRtpTransceiver) -> None:
    """Let a second transceiver of a kind use the one transport of the answer, too.

    aiortc would leave it on that of the first of its kind, which it then stops.
    """
    transceiver._bundled = False


def widen(pc: RTCPeerConnection, extensions: Collection[str]) -> None:
    """Accept what the other end offers and aiortc does not know; call between offer and answer.

    Or, where we have offered it, right after the answer. That is the header extensions with these
    URIs, transport-wide feedback, and redundant audio (RFC 2198) for the chosen codec. Nothing is
    parsed again.
    """
    theirs: SessionDescription = getattr(pc, _OFFER) or getattr(pc, _ANSWER)
    for media in theirs.media:
        for transceiver in pc.getTransceivers():
            if transceiver.mid == media.rtp.muxId and transceiver._codecs:
                _widen(transceiver, media, extensions)


def _widen(
    transceiver: RTCRtpTransceiver, media: MediaDescription, extensions: Collection[str]
) -> None:
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


def break_circles(pc: RTCPeerConnection) -> None:
    """Let go of a closed connection's parts, so that their memory is free at once.

    They hold each other. Many of them would wait for the collector, which stops the event loop for
    as long as it looks through them.
    """
    transports = {transceiver.receiver.transport for transceiver in pc.getTransceivers()}
    if pc.sctp is not None:
        transports.add(pc.sctp.transport)
        pc.sctp.remove_all_listeners()
        for channel in pc.sctp._data_channels.values():
            channel.remove_all_listeners()
        # Those that the page had not closed, and what had not left.
        pc.sctp._data_channels.clear()
        pc.sctp._data_channel_queue.clear()
        for patched in ("_handle_data", "_mark_received", "_send_sack"):
            vars(pc.sctp).pop(patched, None)
    for dtls in transports:
        for one in (dtls, dtls.transport, dtls.transport.iceGatherer):
            one.remove_all_listeners()
        for patched in ("_handle_rtcp_data", "_handle_rtp_data"):
            vars(dtls).pop(patched, None)


def meter_receiving(pc: RTCPeerConnection, meter: Meter) -> None:
    """Charge what each datagram costs to handle, and hand aiortc the next one when it may be.

    Call it once the description of the other end is set: then the transports are those that stay.
    """
    transports = {one.receiver.transport for one in pc.getTransceivers()}
    if pc.sctp is not None:
        transports.add(pc.sctp.transport)
    for dtls in transports:
        _meter(dtls.transport, meter)


def _meter(ice: RTCIceTransport, meter: Meter) -> None:
    cast("Any", ice._connection).meter = meter
    receive = ice._recv
    began_s: float | None = None

    async def metered() -> bytes:
        # aiortc asks for the next datagram when it has done everything with the one before.
        nonlocal began_s
        if began_s is not None:
            meter.charge(began_s)
            began_s = None
        await meter.enter()
        data = await receive()
        began_s = time.thread_time()
        return data

    ice._recv = metered


def on_datagram(transport: RTCDtlsTransport, callback: Callable[[bytes], None]) -> None:
    """Call back with each datagram that aiortc itself sends: all but our media."""
    ice = transport.transport
    send = ice._send

    async def counted(data: bytes) -> None:
        callback(data)
        await send(data)

    ice._send = counted


def on_rtcp(transport: RTCDtlsTransport, callback: Callable[[bytes], None]) -> None:
    """Call back with all incoming RTCP, of which aiortc gets nothing.

    It misreads transport-wide feedback, and makes much of a little. RTP goes nowhere, unless there
    is a receiver of ours.
    """

    async def heard(data: bytes) -> None:
        _note_source(transport, datagram.rtcp_source(data))
        callback(data)

    async def ignored(data: bytes, arrival_time_ms: int) -> None:
        del arrival_time_ms
        _note_source(transport, datagram.rtp_source(data))

    transport._handle_rtcp_data = heard  # type: ignore[method-assign]  # see above
    vars(transport).setdefault("_handle_rtp_data", ignored)


def delay_acknowledgements(sctp: RTCSctpTransport, delay_s: float) -> None:
    """Acknowledge everything within `delay_s` together (RFC 9260, 6.2; at most 200 ms).

    aiortc acknowledges each message at once, in a datagram of 93 bytes: at twenty set-points a
    second, a third of a modem's rate. Messages of many packets are acknowledged immediately.
    """
    acknowledge = sctp._send_sack
    waiting: list[asyncio.TimerHandle] = []
    under_way: set[asyncio.Task[Any]] = set()
    came_s: deque[float] = deque(maxlen=_BURST)

    async def now() -> None:
        came_s.clear()
        while waiting:
            waiting.pop().cancel()
        if sctp.state == "closed":  # while it closes, DTLS refuses data by an error of its own
            return
        with contextlib.suppress(ConnectionError):  # closed meanwhile
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


def bound_association(sctp: RTCSctpTransport, on_excess: Callable[[str], None]) -> None:
    """Bound what a page can make aiortc store, search and answer; before `delay_acknowledgements`.

    `on_excess` gets the reason, once. aiortc keeps fragments without bound and searches all of them
    for each new one. Beyond the bounds the page's data is ignored. Chunks far ahead of a missing
    one are not accepted yet, as a receiver without buffer space may do (RFC 9260, 6.2).
    """
    association = _Association(sctp)
    is_over = False

    async def heard(data: bytes) -> None:
        nonlocal is_over
        if is_over:
            return
        try:
            why = await association.take(data)
        except ConnectionError:
            raise
        except Exception as error:
            # It has the keys, so whatever aiortc stumbles over is its own.
            why = f"it sent what is not understood ({error!r})"
        if why is not None:
            is_over = True
            on_excess(why)

    for name, method in (
        ("_handle_data", heard),
        ("_mark_received", association.mark_received),
        ("_send_sack", association.acknowledge),
    ):
        setattr(sctp, name, method)


class _Association:
    """Takes what a browser sends, and answers with no more than came in.

    Of one packet that is DATA, a SACK, and one chunk that wants an answer: a browser sends one
    HEARTBEAT, RE-CONFIG or COOKIE ECHO at a time.
    """

    def __init__(self, sctp: RTCSctpTransport) -> None:
        self._sctp = sctp
        self._inits = 0
        self._unanswered_bytes = 0

    async def take(self, data: bytes) -> str | None:
        """Handle a packet; return which bound it exceeds, None if none.

        What cannot be parsed is ignored, as RFC 9260 wants it.
        """
        sctp = self._sctp
        found = _chunks(data)
        is_init = bool(found) and found[0][0] == rtcsctptransport.InitChunk.type
        tag = 0 if is_init else sctp._local_verification_tag
        if sctp.state == "closed" or data[4:8] != tag.to_bytes(4):
            return None
        taken: set[int] = set()
        self._unanswered_bytes += len(data)
        for kind, flags, body in found[:1] if is_init else found:
            group = _ANSWERED if kind in _ANSWERED else frozenset((kind,))
            if kind not in _REPEATED and not taken.isdisjoint(group):
                continue
            taken.add(kind)
            try:
                chunk = rtcsctptransport.CHUNK_TYPES[kind](flags, body)
            except (ValueError, struct.error):
                return None
            if (why := await self._take(chunk)) is not None:
                return why
        why = _excess(sctp)
        if why is None and sctp._sack_needed:
            await sctp._send_sack()
        return why

    async def _take(self, chunk: rtcsctptransport.Chunk) -> str | None:
        why = self._refusal(chunk)
        if why is None and not self._ignores(chunk):
            await self._sctp._receive_chunk(chunk)
            why = _too_many_streams(self._sctp)
        return why

    def _refusal(self, chunk: rtcsctptransport.Chunk) -> str | None:
        if isinstance(chunk, rtcsctptransport.SackChunk):
            is_wrong = _acknowledges_unsent(self._sctp, chunk)
            return "it acknowledges what was not sent" if is_wrong else None
        if isinstance(chunk, rtcsctptransport.ForwardTsnChunk):
            is_wrong = len(chunk.streams) > _MAX_STREAMS
        elif isinstance(chunk, rtcsctptransport.ReconfigChunk):
            first = dict(reversed(chunk.params))
            chunk.params = [(kind, first[kind]) for kind in _RECONFIG_BYTES if kind in first]
            is_wrong = any(len(value) > _RECONFIG_BYTES[kind] for kind, value in chunk.params)
        else:
            return None
        return f"it names more than {_MAX_STREAMS} streams" if is_wrong else None

    def _ignores(self, chunk: rtcsctptransport.Chunk) -> bool:
        sctp = self._sctp
        if isinstance(chunk, rtcsctptransport.DataChunk):
            is_too_far = _is_too_far_ahead(sctp, chunk)
            sctp._sack_needed = sctp._sack_needed or is_too_far
            return is_too_far
        if isinstance(chunk, rtcsctptransport.InitChunk):
            self._inits += 1  # nobody begins again with the same keys
            return sctp.state == "connected" or self._inits > _MAX_INITS
        if isinstance(chunk, rtcsctptransport.ShutdownChunk):
            # Whoever leaves so is gone; aiortc would answer ten times.
            sctp._set_state(sctp.State.CLOSED)
            return True
        return False

    def mark_received(self, tsn: int) -> bool:
        """Note a number; whether it came before. aiortc sorts all that wait for each."""
        sctp = self._sctp
        newest, ahead = sctp._last_received_tsn, sctp._sack_misordered
        if newest is None or (tsn - newest - 1) % _UINT32 >= _UINT32 // 2 or tsn in ahead:
            if len(sctp._sack_duplicates) < _MAX_AHEAD:
                sctp._sack_duplicates.append(tsn)
            return True
        ahead.add(tsn)
        while (following := (newest + 1) % _UINT32) in ahead:
            ahead.remove(following)
            newest = following
        sctp._last_received_tsn = newest
        return False

    async def acknowledge(self) -> None:
        """Acknowledge with as many gaps and duplicates as leave it no longer than what came in.

        Numbers that are left out stay unknown to the other end, which sends them again (RFC 9260,
        6.2: as many as fit).
        """
        sctp = self._sctp
        newest = sctp._last_received_tsn
        if newest is None:
            return
        room = max(self._unanswered_bytes - _SACK_BYTES, 0) // 4
        sack = rtcsctptransport.SackChunk()
        sack.cumulative_tsn = newest
        sack.advertised_rwnd = max(0, sctp._advertised_rwnd)
        sack.gaps = _gaps(sctp._sack_misordered, newest)[: min(room, _MAX_AHEAD)]
        sack.duplicates = sctp._sack_duplicates[: min(room, _MAX_AHEAD) - len(sack.gaps)]
        sctp._sack_duplicates.clear()
        sctp._sack_needed = False
        self._unanswered_bytes = 0
        await sctp._send_chunk(sack)


_crc32c: Any = cast("Any", rtcsctptransport).crc32c


def _chunks(packet: bytes) -> list[tuple[int, int, bytes]]:
    """Return type, flags and body of the first chunks that aiortc knows; none of a broken packet.

    aiortc makes objects of all of them.
    """
    found: list[tuple[int, int, bytes]] = []
    at = rtcsctptransport.SCTP_COMMON_HEADER_LENGTH
    if len(packet) < at + 4 or int.from_bytes(packet[8:12], "little") != _crc32c(
        packet[:8] + bytes(4) + packet[12:]
    ):
        return []
    while at + 4 <= len(packet) and len(found) < _MAX_CHUNKS:
        length = int.from_bytes(packet[at + 2 : at + 4])
        if length < 4 or at + length > len(packet):
            return []
        if packet[at] in rtcsctptransport.CHUNK_TYPES:
            found.append((packet[at], packet[at + 1], packet[at + 4 : at + length]))
        at += length + -length % 4
    return found


def _gaps(ahead: Collection[int], newest: int) -> list[tuple[int, int]]:
    """Return the runs of numbers that have come, as distances from the newest in order."""
    gaps: list[tuple[int, int]] = []
    for place in sorted([(tsn - newest) % _UINT32 for tsn in ahead]):
        if gaps and place == gaps[-1][1] + 1:
            gaps[-1] = gaps[-1][0], place
        else:
            gaps.append((place, place))
    return gaps


def _add_chunk(stream: rtcsctptransport.InboundStream, chunk: rtcsctptransport.DataChunk) -> None:
    """Put a chunk in its place among those that wait, which aiortc looks for one by one."""
    before = chunk.tsn - _UINT32 // 2
    insort(stream.reassembly, chunk, key=lambda one: (one.tsn - before) % _UINT32)


def _is_too_far_ahead(sctp: RTCSctpTransport, chunk: rtcsctptransport.DataChunk) -> bool:
    newest: int | None = sctp._last_received_tsn
    if len(sctp._sack_misordered) < _MAX_AHEAD or newest is None:
        return False
    tsn: int = chunk.tsn
    return tsn != (newest + 1) % _UINT32


def _acknowledges_unsent(sctp: RTCSctpTransport, sack: rtcsctptransport.SackChunk) -> bool:
    """Whether gaps cover more than is in flight: aiortc loops over every number in them."""
    under_way: int = (sctp._local_tsn - 1 - sack.cumulative_tsn) % _UINT32
    told: int = sum(max(end - begin + 1, 0) for begin, end in sack.gaps)
    return under_way >= _UINT32 // 2 or told > under_way


def _too_many_streams(sctp: RTCSctpTransport) -> str | None:
    if max(len(sctp._inbound_streams), len(sctp._data_channels)) > _MAX_STREAMS:
        return f"it has more than {_MAX_STREAMS} streams"
    return None


def _excess(sctp: RTCSctpTransport) -> str | None:
    """Return which bound is exceeded, None if none is."""
    waiting = [chunk for stream in sctp._inbound_streams.values() for chunk in stream.reassembly]
    if sum(chunk.flags & _WHOLE != _WHOLE for chunk in waiting) > _MAX_FRAGMENTS:
        return f"more than {_MAX_FRAGMENTS} fragments of messages wait for the rest"
    if sum(len(chunk.user_data) for chunk in waiting) > _MAX_WAITING_BYTES:
        return f"more than {_MAX_WAITING_BYTES} bytes wait for what is missing"
    if len(waiting) > _MAX_AHEAD + _MAX_FRAGMENTS:
        return "too many messages wait for what is missing"
    return None
