"""Datagrams: an admitted page's RTCP, read by aiortc and by us, and STUN from anybody."""

from __future__ import annotations

import math
from itertools import islice
from random import Random
from typing import TYPE_CHECKING, Any, Final, cast

import aioice.ice
from aiortc import RTCDtlsTransport
from aiortc.rtcdtlstransport import RtpRouter
from aiortc.rtp import (
    HeaderExtensionsMap,
    RtcpByePacket,
    RtcpPsfbPacket,
    RtcpReceiverInfo,
    RtcpRrPacket,
    RtcpRtpfbPacket,
    RtcpSdesPacket,
    RtcpSourceInfo,
    RtpPacket,
    is_rtcp,
    pack_remb_fci,
)
from tests.fuzz.target import Target, at_once
from tests.rtc.browser_feedback import feedback_packet
from tests.turned_clock import TurnedClock

from wax.congestion.sender_side import SenderSideControl
from wax.rtc import private
from wax.rtc.one_port.lite_agent import LiteAgent
from wax.rtc.one_port.udp_hub import UdpHub
from wax.rtc.picture_sender import PictureSender
from wax.rtc.sender import Sender, SenderContext
from wax.rtc.sound_sender import SoundSender
from wax.rtc.transport_tap import TransportTap

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from wax.rtc.one_port.lite_agent import Path

_SOUND: Final = 0x11111111
_PICTURE: Final = 0x22222222
_A_TIME: Final = 8
"""Packets sent between two datagrams of the page."""
_DATAGRAMS: Final = 8
"""The most datagrams of one input: the smallest cost more here than their bytes may."""


class Transport(RTCDtlsTransport):
    """aiortc's own handling of decrypted packets, without the encryption under it."""

    def __init__(self) -> None:
        self._role = "auto"
        self._rtp_router = RtpRouter()
        self._rtp_header_extensions_map = HeaderExtensionsMap()

    @property
    def transport(self) -> Any:
        return self

    async def _send(self, data: bytes) -> None: ...

    async def _recv(self) -> bytes:
        raise NotImplementedError


class _Stock:
    """The parts that our senders take over from aiortc's."""

    _rtx_ssrc = 3
    _track_id = "x"

    def __init__(self, ssrc: int, transport: Transport) -> None:
        self._ssrc = ssrc
        self.transport = transport


class _Lane:
    def set_listener(self, news: Callable[[], None]) -> None: ...

    def pop_next(self) -> None: ...


class _Page:
    """Both senders of a peer, some packets in flight, and the handling of the page's answers."""

    def __init__(self) -> None:
        self.clock = TurnedClock(100.0)
        self.keyframes = self.refused = 0
        self.congestion = SenderSideControl(lambda _estimate, _now_s: None)
        self.tap = TransportTap(self.congestion, self.clock.now_s, self._refuse)
        self.transport = Transport()
        self.congestion.negotiated(has_feedback=True)
        self.tap.attach(self.transport)
        senders: tuple[Sender, ...] = (
            SoundSender(self._context(_SOUND), lane=cast("Any", _Lane())),
            PictureSender(
                self._context(_PICTURE),
                lane=cast("Any", _Lane()),
                codec="vp8",
                round_trip_s=lambda: 0.1,
                on_keyframe_wanted=self._want_keyframe,
            ),
        )
        for sender in senders:
            self.tap.add(sender)
        self.send()

    def send(self) -> None:
        for _ in range(_A_TIME):
            self.clock.time_s += 0.002
            self.tap.number_packet(1200, self.clock.time_s, kind="video", train=None)
            self.tap.count_media(1200, self.clock.time_s, has_feedback=True)

    def hear(self, data: bytes) -> None:
        self.clock.time_s += 0.03
        if is_rtcp(data):
            at_once(self.transport._handle_rtcp_data(data))
        else:
            at_once(self.transport._handle_rtp_data(data, arrival_time_ms=0))
        estimate = self.congestion.estimate(self.clock.time_s)
        assert math.isfinite(estimate.rate_bps)
        assert estimate.rate_bps > 0
        assert math.isfinite(estimate.queue_ms)
        wait_s = self.tap.free_in_s(self.clock.time_s)
        assert math.isfinite(wait_s)
        assert wait_s >= 0

    def _context(self, ssrc: int) -> SenderContext:
        return SenderContext(
            stock=cast("Any", _Stock(ssrc, self.transport)),
            rate_hz=90_000,
            tap=self.tap,
            clock=self.clock,
            on_sent=lambda _item: None,
        )

    def _refuse(self) -> None:
        self.refused += 1

    def _want_keyframe(self) -> None:
        self.keyframes += 1


def _datagrams(data: bytes) -> Iterator[bytes]:
    """Split: a byte for the length in words of 32 bits, then as much as there is."""
    at = 0
    while at < len(data):
        end = at + 1 + 4 * data[at]
        if len(one := data[at + 1 : end]) > 1:  # an encrypted datagram is longer
            yield one
        at = end


def _joined(*datagrams: bytes) -> bytes:
    return b"".join(bytes((len(one) // 4,)) + one for one in datagrams)


def _hear_rtcp(data: bytes) -> None:
    private.install()
    page = _Page()
    for datagram in islice(_datagrams(data), _DATAGRAMS):
        page.hear(datagram)
        page.send()


def _arrivals(first: int, *ticks: int | None) -> bytes:
    return feedback_packet(first, ticks, Random(1))


_REPORT: Final = bytes(
    RtcpRrPacket(
        ssrc=1,
        reports=[
            RtcpReceiverInfo(
                ssrc=_PICTURE, fraction_lost=9, packets_lost=1, highest_sequence=2, jitter=3,
                lsr=4, dlsr=5,
            )
        ],
    )
)  # fmt: skip
_NAME: Final = bytes(RtcpSdesPacket(chunks=[RtcpSourceInfo(ssrc=1, items=[(1, b"n")])]))
_REMB: Final = bytes(
    RtcpPsfbPacket(fmt=15, ssrc=1, media_ssrc=0, fci=pack_remb_fci(10**6, [_PICTURE]))
)

RTCP: Final = Target(
    name="rtcp",
    what="RTCP and transport feedback",
    hear=_hear_rtcp,
    seeds=(
        _joined(_arrivals(0, 0, 8, 16, None, 32, 40), _arrivals(6, 48, 500, None, None, 90)),
        _joined(_arrivals(0, *range(0, 800, 100)), _arrivals(8, *range(5000, 5800, 100))),
        _joined(_REPORT + _NAME),
        _joined(bytes(RtcpRtpfbPacket(fmt=1, ssrc=1, media_ssrc=_PICTURE, lost=[1, 2, 40]))),
        _joined(bytes(RtcpPsfbPacket(fmt=1, ssrc=1, media_ssrc=_PICTURE))),
        _joined(_REMB),
        _joined(bytes(RtcpByePacket(sources=[_SOUND]))),
        _joined(RtpPacket(payload_type=96, ssrc=_PICTURE, payload=b"xyz!").serialize()),
    ),
    words=(
        b"\x8f\xcd", b"\xaf\xcd", b"\x81\xc9\x00\x07", b"\x81\xcd", b"\x81\xce", b"\x8f\xce",
        b"\x81\xcb", _PICTURE.to_bytes(4, "big"), _SOUND.to_bytes(4, "big"), b"\x1f\xff",
        b"\xbf\xff", b"\xd9\x00", b"REMB",
    ),
    steps=80_000,
)  # fmt: skip


class _Receiver:
    """An ICE connection that has no pair yet."""

    def data_received(self, data: bytes, component: int) -> None: ...

    def request_received(self, message: object, addr: object, protocol: object) -> None: ...


class _Protocol(aioice.ice.StunProtocol):
    """One socket's handling of datagrams, without the event loop that it needs."""

    def __init__(self) -> None:
        self.id = 1
        self.receiver = cast("Any", _Receiver())
        self.transactions = {}
        self.local_candidate = aioice.Candidate("1", 1, "udp", 1, "192.0.2.1", 9, "host")


def _hear_stun(data: bytes) -> None:
    private.install()
    _Protocol().datagram_received(data, ("192.0.2.9", 9))


def _binding(**attributes: object) -> bytes:
    message = aioice.stun.Message(
        message_method=aioice.stun.Method.BINDING,
        message_class=aioice.stun.Class.REQUEST,
        transaction_id=b"0123456789ab",
    )
    message.attributes.update({name.replace("_", "-"): v for name, v in attributes.items()})
    return bytes(message)


STUN: Final = Target(
    name="stun",
    what="STUN of strangers",
    hear=_hear_stun,
    seeds=(
        _binding(),
        _binding(USERNAME="a:b", PRIORITY=1, ICE_CONTROLLING=2, USE_CANDIDATE=None),
        _binding(XOR_MAPPED_ADDRESS=("192.0.2.1", 9), SOFTWARE="x", ERROR_CODE=(401, "no")),
    ),
    words=(
        b"\x00\x01\x00\x08", b"\x00\x06\x00\x01", b"\x00\x24\x00\x02", b"\x80\x28\x00\x04",
        b"\x00\x20\x00\x01", b"\x00\x09\x00\x02", b"\x21\x12\xa4\x42",
    ),
    max_bytes=600,
)  # fmt: skip


class _Meter:
    """Charges nobody: charging would need the event loop."""

    is_open = True

    def charge(self, began_s: float) -> None: ...


class _Viewer:
    """A peer of the one port, as far as it works without an event loop."""

    meter = cast("Any", _Meter())
    has_room = is_quiet = True

    def __init__(self) -> None:
        self.agent = LiteAgent(now_s=0.0)
        self.agent.username, self.agent.password = "ours", "secret"
        self.agent.remote_username, self.agent.remote_password = "theirs", "secret"

    def handle_stun(self, message: aioice.stun.Message, path: Path) -> None:
        self.agent.handle_request(message, path, 0.0)
        self.agent.handle_response(message, path, 0.0)
        assert self.agent.selected is None  # only an answer to our random check does that

    def handle_datagram(self, data: bytes, path: Path) -> None: ...

    def try_stray(self, data: bytes, path: Path) -> None:
        assert data[0] == 23  # the packets inside DTLS's encryption, and nothing else

    def lose_path(self, path: Path) -> None: ...


def _hear_one_port(data: bytes) -> None:
    private.install()
    hub = UdpHub(8081, list)
    hub.add("ours", _Viewer())
    hub.received(0, data, "192.0.2.9", 9)


def _signed(**attributes: object) -> bytes:
    message = aioice.stun.parse_message(_binding(**attributes))
    message.add_message_integrity(b"secret")
    return bytes(message)


ONE_PORT: Final = Target(
    name="one-port",
    what="datagrams to the one port",
    hear=_hear_one_port,
    seeds=(
        *STUN.seeds,
        _signed(USERNAME="ours:theirs", PRIORITY=1, ICE_CONTROLLING=2, USE_CANDIDATE=None),
        _signed(USERNAME="ours:others"),
        b"\x80\x60" + bytes(20),
        b"\x17\xfe\xfd\x00\x01" + bytes(20),
        b"",
    ),
    words=(*STUN.words, b"ours:theirs", b"\x00\x08\x00\x14", b"\x01\x01"),
    max_bytes=600,
)
