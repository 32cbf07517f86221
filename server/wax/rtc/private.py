"""All uses of private parts of aiortc and its dependencies, and why; SCTP has its own file.

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
from contextvars import ContextVar
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, cast

import aioice.candidate
import aioice.ice
import aioice.stun
import pylibsrtp
import structlog
from aiortc import (
    RTCCertificate,
    RTCDtlsTransport,
    RTCIceGatherer,
    RTCIceTransport,
    RTCPeerConnection,
    RTCRtpReceiver,
    RTCRtpSender,
    RTCSctpTransport,
    rtcdtlstransport,
    rtcicetransport,
    rtcrtpreceiver,
    rtcsctptransport,
)
from aiortc.rtcrtpparameters import (
    ParametersDict,
    RTCRtcpFeedback,
    RTCRtpCodecParameters,
    RTCRtpHeaderExtensionParameters,
)
from aiortc.rtcrtptransceiver import RTCRtpTransceiver
from cryptography.hazmat.primitives.asymmetric import ec, ed25519, rsa
from OpenSSL import SSL

from wax.errors import StartError
from wax.rtc import datagram
from wax.rtc.private_association import MAX_WAITING_BYTES, add_chunk

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Collection, Iterable, Iterator, Sequence

    from aiortc.mediastreams import MediaStreamTrack
    from aiortc.rtcdtlstransport import RTCDtlsParameters
    from aiortc.rtcicetransport import RTCIceParameters
    from aiortc.rtcrtpparameters import RTCRtpReceiveParameters, RTCRtpSendParameters
    from aiortc.rtp import AnyRtcpPacket
    from aiortc.sdp import MediaDescription, SessionDescription
    from OpenSSL import crypto

    from wax.edge.turnstile import Meter

_LOG = structlog.get_logger(__name__)

_FOR_EVER: Final = 10**9
_SENDER: Final = "_RTCRtpTransceiver__sender"
_RECEIVER: Final = "_RTCRtpTransceiver__receiver"
_OFFER: Final = "_RTCPeerConnection__pendingRemoteDescription"
_ANSWER: Final = "_RTCPeerConnection__currentRemoteDescription"
_CHANNELS: Final = "_RTCPeerConnection__createSctpTransport"
_CERTIFICATES: Final = "_RTCPeerConnection__certificates"
_CERTIFICATE: Final = "_RTCDtlsTransport__local_certificate"
_FEEDBACK: Final = RTCRtcpFeedback(type="transport-cc")
_RED: Final = "audio/red"
_MAX_WAITING: Final = 128
"""Datagrams that aiortc has not read yet, as on the one port."""
_COOKIE: Final = aioice.stun.COOKIE.to_bytes(4, "big")
RELAY_AFTER_S: Final = 0.8
"""Longer than aioice takes to retransmit a check: two NATs let only its second attempt through."""
MOST_HELD: Final = 64
"""Datagrams from the relay to hold back: more, handled all at once, would delay a Stop."""
_MAX_RSA_BITS: Final = 4096
_MAX_RSA_EXPONENT: Final = 2**32
"""Real keys have 65537; an exponent of 3,072 bits takes OpenSSL 7 ms."""
_MESSAGES_S: Final = 0.0005
"""Time per pass of the event loop for the messages of one datagram; each pass handles at least one.
"""
_MAX_SOURCES: Final = 32
"""SSRCs of one browser: a few for its reports, and one for a voice."""


_HAVE: Final[tuple[tuple[Any, str], ...]] = (
    (aioice.ice, "CONSENT_FAILURES get_host_addresses"),
    (aioice.ice.Connection, "data_received"),
    (aioice.stun, "COOKIE Class Message Method parse_message"),
    (aioice.candidate, "candidate_foundation candidate_priority"),
    (pylibsrtp, "ffi lib _srtp_assert"),
    (RTCCertificate, "_create_ssl_context"),
    (RTCDtlsTransport, "_recv_next _set_state _handle_rtp_data _handle_rtcp_data"),
    (RTCDtlsTransport, "_register_rtp_sender _unregister_rtp_sender"),
    (RTCIceGatherer, "getLocalParameters"),
    (RTCPeerConnection, _CHANNELS),
    (rtcicetransport, "Connection"),
    (rtcrtpreceiver, "RemoteBitrateEstimator"),
    (RTCSctpTransport, "_handle_data _mark_received _receive _receive_chunk _send_chunk"),
    (RTCSctpTransport, "_t3_start _t3_restart _send_sack _set_state"),
    (rtcsctptransport, "CHUNK_TYPES DataChunk ForwardTsnChunk InitChunk ReconfigChunk SackChunk"),
    (rtcsctptransport, "ShutdownChunk LOCAL_MAX_MESSAGE_SIZE crc32c decode_params"),
    (rtcsctptransport.InboundStream, "add_chunk"),
)
"""Modules and classes, and what they must have."""

_SET: Final[tuple[tuple[type, str], ...]] = (
    (aioice.ice.Connection, "_nominated _queue _transport_policy"),
    (pylibsrtp.Session, "_srtp"),
    (RTCDtlsTransport, f"_state _tx_srtp {_CERTIFICATE}"),
    (RTCIceGatherer, "_connection"),
    (RTCIceTransport, "_connection _recv _send"),
    (RTCPeerConnection, f"{_OFFER} {_ANSWER} {_CERTIFICATES}"),
    (RTCRtpReceiver, "_track"),
    (RTCRtpSender, "_ssrc _rtx_ssrc"),
    (RTCRtpTransceiver, f"_codecs _headerExtensions {_SENDER} {_RECEIVER}"),
    (RTCSctpTransport, "_advertised_rwnd _data_channel_queue _data_channels _inbound_streams"),
    (RTCSctpTransport, "_last_received_tsn _local_tsn _local_verification_tag"),
    (RTCSctpTransport, "_sack_duplicates _sack_misordered _sack_needed"),
    (SSL.Context, "_verify_callback _verify_helper"),
)
"""Classes, and the attributes that their `__init__` must set."""

_PATCHED: Final = ("_handle_data", "_mark_received", "_receive", "_send_sack", "_send_chunk")
"""Methods of an association that are replaced for one peer."""


def check() -> None:
    """Raise a `StartError` that names each private part that this version lacks."""
    found = [(owner, name, hasattr(owner, name)) for owner, name in _each(_HAVE)]
    found += [(owner, name, _uses(owner.__init__, name)) for owner, name in _each(_SET)]
    stun = aioice.ice.StunProtocol  # asyncio's own protocol has the method, too
    found.append((stun, "datagram_received", "datagram_received" in vars(stun)))
    found.append((RTCRtpSender, "_track_id", _uses(RTCRtpSender.replaceTrack, "_track_id")))
    missing = [f"{owner.__name__}.{name}" for owner, name, there in found if not there]
    if missing:
        raise StartError(
            "this version of aiortc or aioice is not the one WAX was built for "
            f"({', '.join(missing)} moved); install the versions of requirements.lock"
        )


def _each(parts: Iterable[tuple[Any, str]]) -> Iterator[tuple[Any, str]]:
    return ((owner, name) for owner, names in parts for name in names.split())


def _uses(method: Any, name: str) -> bool:
    return name in method.__code__.co_names


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
    cast("Any", RTCDtlsTransport).start = _start_dtls
    cast("Any", RTCCertificate)._create_ssl_context = _ssl_context
    cast("Any", RTCCertificate).generateCertificate = _certificate
    aioice.stun.parse_message = _parsed_stun
    cast("Any", rtcicetransport).Connection = _connection
    cast("Any", RTCIceGatherer).getLocalParameters = _local_parameters
    # aiortc makes one per picture, in 0.3 ms and 95 KiB, though nothing is received.
    cast("Any", rtcrtpreceiver).RemoteBitrateEstimator = lambda: None
    rtcsctptransport.decode_params = _decoded_params
    cast("Any", rtcsctptransport.InboundStream).add_chunk = add_chunk
    # The limit in our answer, so that the browser sends nothing longer.
    rtcsctptransport.LOCAL_MAX_MESSAGE_SIZE = MAX_WAITING_BYTES


@dataclass(frozen=True, slots=True)
class Reach:
    """How one peer reaches the network.

    `connect` makes a replacement for aioice's connection; without it aioice gathers on `addresses`,
    or by default on all addresses of this machine. Without `certificate` it has one of its own.
    """

    connect: Callable[[], Any] | None = None
    addresses: Callable[[], list[str]] | None = None
    certificate: RTCCertificate | None = None


_reach: ContextVar[Reach | None] = ContextVar("reach", default=None)


@contextlib.contextmanager
def reached_by(reach: Reach) -> Iterator[None]:
    """Make peers created and answered inside reach the network this way.

    The block must contain the constructor and the making of the answer: in both aiortc makes a
    connection for each section, and after the latter it gathers.
    """
    token = _reach.set(reach)
    try:
        yield
    finally:
        _reach.reset(token)


def _connection(**options: Any) -> Any:
    reach = _reach.get()
    if reach is None or reach.connect is None:
        return _stock_connection(**options)
    return reach.connect()


_stock_connection = aioice.ice.Connection


def _certificate() -> RTCCertificate:
    """Return the certificate that this peer shares with others, or a new one."""
    reach = _reach.get()
    if reach is None or reach.certificate is None:
        return _stock_certificate()
    return reach.certificate


_stock_certificate = RTCCertificate.generateCertificate


def _local_parameters(gatherer: RTCIceGatherer) -> RTCIceParameters:
    """Mark a lite connection as such in the answer (``a=ice-lite``)."""
    parameters = _stock_local_parameters(gatherer)
    parameters.iceLite = getattr(gatherer._connection, "is_lite", False)
    return parameters


_stock_local_parameters = RTCIceGatherer.getLocalParameters


def _host_addresses(use_ipv4: bool, use_ipv6: bool) -> list[str]:
    """Return the chosen addresses, or 127.0.0.1 on a machine with only loopback."""
    reach = _reach.get()
    if reach is not None and reach.addresses is not None:
        return [
            address for address in reach.addresses() if (use_ipv6 if ":" in address else use_ipv4)
        ]
    return _stock_host_addresses(use_ipv4, use_ipv6) or (["127.0.0.1"] if use_ipv4 else [])


_stock_host_addresses = aioice.ice.get_host_addresses


class _Guard:
    """Receives an ICE transport's datagrams, without those that cannot be genuine."""

    def __init__(self, receive: Callable[[], Awaitable[bytes]], *, is_known: bool) -> None:
        self._receive = receive
        self._is_known = is_known
        self.taken = 0
        self.sources: set[bytes] = set()
        """Authenticated SSRCs: libsrtp keeps a state of each for ever."""

    async def __call__(self) -> bytes:
        while not self._may_pass(data := await self._receive()):
            pass
        self.taken += 1
        return data

    def _may_pass(self, data: bytes) -> bool:
        if not datagram.is_plausible(data):
            return False
        if not self._is_known and datagram.has_long_certificate(data):
            return False
        source = datagram.source(data)
        return source is None or source in self.sources or len(self.sources) < _MAX_SOURCES


def _note_source(dtls: RTCDtlsTransport, source: bytes) -> None:
    guard: Any = dtls.transport._recv
    if isinstance(guard, _Guard):
        guard.sources.add(source)


async def _receive_next(dtls: RTCDtlsTransport) -> None:
    """Handle one datagram; its sender may be forged, so its errors must not end the peer.

    Authenticated contents are handled by functions of our own, which do not raise.
    """
    ice: Any = dtls.transport
    if not isinstance(ice._recv, _Guard):
        ice._recv = _Guard(ice._recv, is_known=_is_known(getattr(dtls, _CERTIFICATE)))
    before = ice._recv.taken
    try:
        await _stock_recv_next(dtls)
    except ConnectionError:
        raise
    except Exception as error:
        if ice._recv.taken == before:
            raise  # no datagram was read, so this would repeat for ever
        _LOG.info("a datagram was not understood", error=repr(error))


_stock_recv_next = RTCDtlsTransport._recv_next


async def _start_dtls(dtls: RTCDtlsTransport, theirs: RTCDtlsParameters) -> None:
    """Skip the handshake if ICE has failed: aiortc would make its keys, which takes 1 ms."""
    if dtls.transport.state == "completed":
        await _stock_start_dtls(dtls, theirs)
    else:
        dtls._set_state(rtcdtlstransport.State.FAILED)


_stock_start_dtls = RTCDtlsTransport.start


def mark_other_end_known(pc: RTCPeerConnection) -> None:
    """Accept any certificate of the other end, which the host has configured."""
    for certificate in getattr(pc, _CERTIFICATES):
        vars(certificate)["is_other_end_known"] = True


def _is_known(certificate: RTCCertificate) -> bool:
    return "is_other_end_known" in vars(certificate)


def _ssl_context(certificate: RTCCertificate, srtp_profiles: list[Any]) -> SSL.Context:
    """Verify no certificate chain: the fingerprint in the offer vouches for the leaf alone."""
    context: SSL.Context = _stock_ssl_context(certificate, srtp_profiles=srtp_profiles)
    if _is_known(certificate):
        return context
    context.set_verify(SSL.VERIFY_PEER | SSL.VERIFY_FAIL_IF_NO_PEER_CERT, _is_cheap_leaf)
    # A cycle; the context itself keeps the callback.
    cast("Any", context._verify_helper).callback = None
    return context


_stock_ssl_context = RTCCertificate._create_ssl_context


def _is_cheap_leaf(
    _connection: SSL.Connection, certificate: crypto.X509, _error: int, depth: int, _ok: int
) -> bool:
    """Return whether verifying signatures by this certificate's key takes under a millisecond.

    OpenSSL calls this before it verifies any signature, because it knows no issuer of the chain.
    """
    key = certificate.get_pubkey().to_cryptography_key() if depth == 0 else None
    if isinstance(key, rsa.RSAPublicKey):
        return key.key_size <= _MAX_RSA_BITS and key.public_numbers().e <= _MAX_RSA_EXPONENT
    return isinstance(key, (ec.EllipticCurvePublicKey, ed25519.Ed25519PublicKey))


def _data_received(connection: aioice.ice.Connection, data: bytes, component: int) -> None:
    """Keep only the newest unread datagrams; aioice's queue is unbounded."""
    if connection._queue.qsize() >= _MAX_WAITING:
        connection._queue.get_nowait()
    _stock_data_received(connection, data, component)


_stock_data_received = aioice.ice.Connection.data_received


def _datagram_received(
    protocol: aioice.ice.StunProtocol, data: bytes, address: tuple[Any, ...]
) -> None:
    """Charge the peer for checks, which aioice answers at once; all else is charged when read."""
    meter: Meter | None = getattr(protocol.receiver, "meter", None)
    if (wait_s := _early_s(protocol)) > 0:
        _hold_back(wait_s, protocol, data, address)
    elif meter is None or data[4:8] != _COOKIE:
        _stock_datagram_received(protocol, data, address)
    elif meter.is_open:
        began_s = time.thread_time()
        _stock_datagram_received(protocol, data, address)
        meter.charge(began_s)


_stock_datagram_received = aioice.ice.StunProtocol.datagram_received


def _hold_back(
    wait_s: float, protocol: aioice.ice.StunProtocol, data: bytes, address: tuple[Any, ...]
) -> None:
    """Handle the first `MOST_HELD` later and drop the others, since checks are retransmitted."""
    kept: dict[str, Any] = vars(protocol.receiver)
    kept["relay_held"] = held = kept.get("relay_held", 0) + 1
    if held <= MOST_HELD:
        asyncio.get_running_loop().call_later(wait_s, _late, protocol, data, address)


def _late(protocol: aioice.ice.StunProtocol, data: bytes, address: tuple[Any, ...]) -> None:
    """Handle a held datagram, unless a pair has been nominated meanwhile."""
    if not protocol.receiver._nominated:
        _datagram_received(protocol, data, address)


def _early_s(protocol: aioice.ice.StunProtocol) -> float:
    """Return how long a datagram from our relay waits, as a direct path may still be found.

    aioice takes the first pair that works and gives up all others (RFC 8445, 8.1.1 leaves it to the
    other side to wait), and a relay has no NAT to open: it would always win.
    """
    ice: Any = protocol.receiver
    local = protocol.local_candidate
    if local is None or local.type != "relay" or ice._nominated:
        return 0.0
    if ice._transport_policy == aioice.ice.TransportPolicy.RELAY:
        return 0.0
    now_s = time.monotonic()
    since_s: float = vars(ice).setdefault("relay_since_s", now_s)
    return since_s + RELAY_AFTER_S - now_s


def _parsed_stun(data: bytes) -> aioice.stun.Message:
    """Parse a message; raise `ValueError`, as aioice expects, for attributes of a wrong length.

    Refuse also what is longer than any frame, since aioice makes an object of each attribute.
    """
    if len(data) > datagram.MAX_BYTES:
        raise ValueError("a STUN message that is longer than a datagram")
    try:
        return _stock_parse_message(data)
    except (struct.error, IndexError) as error:
        raise ValueError(f"a STUN attribute of a wrong length: {error}") from error


_stock_parse_message = aioice.stun.parse_message


def _decoded_params(body: bytes) -> list[tuple[int, bytes]]:
    """Refuse a parameter of length zero (RFC 9260, 3.2.1), on which aiortc loops for ever."""
    at = 0
    while at <= len(body) - 4:
        length = int.from_bytes(body[at + 2 : at + 4])
        if length < 4:
            raise ValueError("an SCTP parameter that is shorter than its header")
        at += length + -length % 4
    return _stock_decode_params(body)


_stock_decode_params = rtcsctptransport.decode_params


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
            self.start_sending(parameters)

    async def stop(self) -> None:
        """End for good; safe to call twice."""
        if self._is_sending:
            self._is_sending = False
            self._transport._unregister_rtp_sender(self)
            self.stop_sending()

    async def _handle_rtcp_packet(self, packet: AnyRtcpPacket) -> None:
        del packet  # never called: `on_rtcp` takes all RTCP

    @abstractmethod
    def start_sending(self, parameters: RTCRtpSendParameters) -> None:
        """Start sending as negotiated."""

    @abstractmethod
    def stop_sending(self) -> None:
        """Stop sending."""


class ReceiverInPlace(ABC):
    """Replaces aiortc's receiver `stock` in a transceiver.

    aiortc's receiver starts a thread for each stream, queues without bound and buffers 80 ms of
    sound. This one has the attributes and methods that aiortc uses on it. It gets all decrypted RTP
    of its transport; aiortc gets none, as its router would keep each SSRC that a page makes up.
    """

    def __init__(self, stock: RTCRtpReceiver) -> None:
        self._enabled = True
        self._track: MediaStreamTrack | None = None
        self._transport = stock.transport
        self._is_receiving = False

    @property
    def track(self) -> MediaStreamTrack | None:
        """The track that aiortc makes of the offer; it never gets any media."""
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
            self.start_receiving(parameters)
            self._transport._handle_rtp_data = self._handle_rtp_data  # type: ignore[method-assign]  # see above

    async def stop(self) -> None:
        """End for good; safe to call twice."""
        self._is_receiving = False

    async def _handle_rtp_data(self, data: bytes, arrival_time_ms: int) -> None:
        del arrival_time_ms  # from another clock
        _note_source(self._transport, datagram.rtp_source(data))
        if self._is_receiving:
            self.handle_rtp(data)

    @abstractmethod
    def start_receiving(self, parameters: RTCRtpReceiveParameters) -> None:
        """Start receiving as negotiated."""

    @abstractmethod
    def handle_rtp(self, packet: bytes) -> None:
        """Handle an RTP packet with any content; must not raise."""


_srtp: Any = pylibsrtp


class DtlsMediaTransport:
    """The keys and the path of one DTLS transport (`egress.MediaTransport`)."""

    def __init__(self, dtls: RTCDtlsTransport) -> None:
        self._dtls = dtls
        self._size = _srtp.ffi.new("int *")
        self._memory: Any = None

    def protect(self, buffer: bytearray, at: int, size: int, *, is_rtcp: bool) -> int:
        """Protect a packet in place; pylibsrtp would copy it twice."""
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
        """Send on the shared port, or on the pair that aioice nominated last."""
        connection: Any = self._dtls.transport._connection
        if hasattr(connection, "send_together"):
            connection.send_together(datagrams, sizes)
            return
        pair = connection._nominated.get(1)
        if pair is None:
            raise ConnectionError("there is no nominated pair")
        at = 0
        for size in sizes:
            # A relayed pair has such a transport, too.
            pair.protocol.transport.sendto(bytes(datagrams[at : at + size]), pair.remote_addr)
            at += size


def put_sender(transceiver: RTCRtpTransceiver, sender: SenderInPlace) -> None:
    """Use our sender in this transceiver; aiortc has no public way to replace it."""
    setattr(transceiver, _SENDER, sender)


def put_receiver(transceiver: RTCRtpTransceiver, receiver: ReceiverInPlace) -> None:
    """Use our receiver in this transceiver, after `put_sender`; see there."""
    setattr(transceiver, _RECEIVER, receiver)


def follow_bundle(transceiver: RTCRtpTransceiver) -> None:
    """Let another transceiver of the same kind use the bundled transport of the answer.

    aiortc would leave it on the transport of the first of its kind, which it then stops.
    """
    transceiver._bundled = False


def offer_channels(pc: RTCPeerConnection) -> None:
    """Let our offer have room for the other end's data channels, without opening one of ours.

    Call it once there is a transceiver, with whose transport it is then bundled.
    """
    getattr(pc, _CHANNELS)()


def widen(pc: RTCPeerConnection, extensions: Collection[str]) -> None:
    """Accept what the other end offers and aiortc does not know.

    These are the header extensions with these URIs, transport-wide feedback, and redundant audio
    (RFC 2198) for the chosen codec. Call it between offer and answer or, if we made the offer,
    right after the answer. Nothing is parsed again.
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


def break_cycles(pc: RTCPeerConnection) -> None:
    """Break a closed connection's reference cycles, so that its memory is freed at once.

    Many closed connections would wait for the garbage collector, which stops the event loop while
    it traverses them.
    """
    transports = {transceiver.receiver.transport for transceiver in pc.getTransceivers()}
    if pc.sctp is not None:
        transports.add(pc.sctp.transport)
        pc.sctp.remove_all_listeners()
        for channel in pc.sctp._data_channels.values():
            channel.remove_all_listeners()
        # Channels that the page had not closed, and messages that had not left.
        pc.sctp._data_channels.clear()
        pc.sctp._data_channel_queue.clear()
        for patched in _PATCHED:
            vars(pc.sctp).pop(patched, None)
    for dtls in transports:
        for one in (dtls, dtls.transport, dtls.transport.iceGatherer):
            one.remove_all_listeners()
        for patched in ("_handle_rtcp_data", "_handle_rtp_data"):
            vars(dtls).pop(patched, None)


def meter_receiving(pc: RTCPeerConnection, meter: Meter) -> None:
    """Charge the cost of handling each datagram, and hand aiortc the next when the meter allows.

    The messages of a datagram take no longer together: one may complete hundreds that have waited
    for it. Call it once the remote description is set: from then on the transports stay the same.
    """
    transports = {one.receiver.transport for one in pc.getTransceivers()}
    if pc.sctp is not None:
        transports.add(pc.sctp.transport)
    for dtls in transports:
        ice = dtls.transport
        cast("Any", ice._connection).meter = meter
        ice._recv = metered = _Metered(ice._recv, meter)
        if pc.sctp is not None and dtls is pc.sctp.transport:
            _pause_between_messages(pc.sctp, metered)


class _Metered:
    """Receives a peer's datagrams; aiortc asks for the next once it has handled the last."""

    def __init__(self, receive: Callable[[], Awaitable[bytes]], meter: Meter) -> None:
        self._receive = receive
        self._meter = meter
        self._began_s: float | None = None
        self._messages = 0

    async def __call__(self) -> bytes:
        if self._began_s is not None:
            self._meter.charge(self._began_s)
            self._began_s = None
        await self._meter.enter()
        data = await self._receive()
        self._began_s, self._messages = time.thread_time(), 0
        return data

    async def before_message(self) -> None:
        """Let others go on between the messages of a datagram that takes long.

        One that brings a single message never waits: an operator's commands are all like that, and
        a pass of the loop for each would make them too old on a busy machine.
        """
        self._messages += 1
        if self._began_s is None or self._messages == 1:
            return
        if time.thread_time() - self._began_s < _MESSAGES_S:
            return
        self._meter.charge(self._began_s)
        await asyncio.sleep(0)
        await self._meter.enter()
        self._began_s = time.thread_time()


def _pause_between_messages(sctp: RTCSctpTransport, metered: _Metered) -> None:
    receive = sctp._receive

    async def received(stream_id: int, pp_id: int, data: bytes) -> None:
        await metered.before_message()
        await receive(stream_id, pp_id, data)

    sctp._receive = received  # type: ignore[method-assign]  # see above


def report_authenticated(sctp: RTCSctpTransport) -> None:
    """Tell the one port which datagrams were authenticated; call it after `bound_association`.

    SCTP gets only authenticated data from DTLS, and only once: DTLS drops replays (RFC 6347,
    4.1.2.6).
    """
    connection: Any = cast("Any", sctp.transport.transport)._connection
    if not getattr(connection, "is_lite", False):
        return
    take = sctp._handle_data

    async def heard(data: bytes) -> None:
        connection.authenticated()
        await take(data)

    sctp._handle_data = heard  # type: ignore[method-assign]  # see above


def on_datagram(transport: RTCDtlsTransport, callback: Callable[[bytes], None]) -> None:
    """Call back with each datagram that aiortc itself sends: all but our media."""
    ice = transport.transport
    send = ice._send

    async def counted(data: bytes) -> None:
        callback(data)
        await send(data)

    ice._send = counted


def on_rtcp(transport: RTCDtlsTransport, callback: Callable[[bytes], None]) -> None:
    """Call back with all incoming RTCP, and keep it from aiortc.

    aiortc misreads transport-wide feedback, and makes many objects of few bytes. RTP is dropped,
    unless there is a receiver of ours.
    """

    async def heard(data: bytes) -> None:
        _note_source(transport, datagram.rtcp_source(data))
        callback(data)

    async def ignored(data: bytes, arrival_time_ms: int) -> None:
        del arrival_time_ms
        _note_source(transport, datagram.rtp_source(data))

    transport._handle_rtcp_data = heard  # type: ignore[method-assign]  # see above
    vars(transport).setdefault("_handle_rtp_data", ignored)
