"""The private parts of aiortc that WAX uses are unchanged."""

from __future__ import annotations

import asyncio
import re
import time
from functools import partial
from typing import TYPE_CHECKING, Any, cast

import aioice
import aioice.candidate
import aioice.ice
import aioice.stun
import pylibsrtp
import pytest
from aiortc import (
    RTCCertificate,
    RTCDtlsTransport,
    RTCIceGatherer,
    RTCIceTransport,
    RTCPeerConnection,
    RTCRtpReceiver,
    RTCRtpSender,
    RTCSctpTransport,
    RTCSessionDescription,
    rtcicetransport,
    rtcsctptransport,
)
from aiortc.rtcrtptransceiver import RTCRtpTransceiver
from tests.rtc.networks import rich_meter

from wax.clock import SystemClock
from wax.edge.turnstile import Meter
from wax.errors import StartError
from wax.rtc import private, private_association, rtp
from wax.rtc.one_port.lite_connection import LiteConnection
from wax.rtc.one_port.udp_hub import UdpHub

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable


def test_all_private_parts_are_there() -> None:
    """The installed versions have every private part that WAX uses."""
    private.check()


@pytest.mark.parametrize(
    ("owner", "name"),
    [
        (aioice.ice, "CONSENT_FAILURES"),
        (aioice.ice, "get_host_addresses"),
        (aioice.ice.Connection, "data_received"),
        (aioice.ice.StunProtocol, "datagram_received"),
        (RTCDtlsTransport, "_recv_next"),
        (RTCDtlsTransport, "_set_state"),
        (aioice.stun, "parse_message"),
        (aioice.stun, "COOKIE"),
        (aioice.candidate, "candidate_priority"),
        (rtcicetransport, "Connection"),
        (RTCIceGatherer, "getLocalParameters"),
        (pylibsrtp, "_srtp_assert"),
        (RTCCertificate, "_create_ssl_context"),
        (RTCDtlsTransport, "_handle_rtcp_data"),
        (RTCDtlsTransport, "_handle_rtp_data"),
        (RTCDtlsTransport, "_register_rtp_sender"),
        (RTCDtlsTransport, "_unregister_rtp_sender"),
        (RTCSctpTransport, "_send_sack"),
        (RTCSctpTransport, "_receive_chunk"),
        (RTCSctpTransport, "_handle_data"),
        (RTCSctpTransport, "_mark_received"),
        (RTCSctpTransport, "_send_chunk"),
        (RTCSctpTransport, "_set_state"),
        (rtcsctptransport.InboundStream, "add_chunk"),
        (rtcsctptransport, "decode_params"),
        (rtcsctptransport, "LOCAL_MAX_MESSAGE_SIZE"),
        (rtcsctptransport, "CHUNK_TYPES"),
        (rtcsctptransport, "crc32c"),
        (rtcsctptransport, "DataChunk"),
        (rtcsctptransport, "SackChunk"),
    ],
)
def test_a_part_that_moved_is_named(
    owner: object, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A version that has moved a part is refused at start, with the part's name."""
    monkeypatch.delattr(owner, name)
    with pytest.raises(StartError, match=name):
        private.check()


@pytest.mark.parametrize(
    ("owner", "method", "name"),
    [
        (RTCPeerConnection, "__init__", "__pendingRemoteDescription"),
        (RTCPeerConnection, "__init__", "__currentRemoteDescription"),
        (RTCPeerConnection, "__init__", "__certificates"),
        (RTCDtlsTransport, "__init__", "__local_certificate"),
        (RTCRtpTransceiver, "__init__", "__sender"),
        (RTCRtpTransceiver, "__init__", "__receiver"),
        (RTCRtpReceiver, "__init__", "_track"),
        (RTCRtpTransceiver, "__init__", "_codecs"),
        (RTCRtpTransceiver, "__init__", "_headerExtensions"),
        (RTCRtpSender, "__init__", "_ssrc"),
        (RTCRtpSender, "__init__", "_rtx_ssrc"),
        (RTCRtpSender, "replaceTrack", "_track_id"),
        (RTCIceGatherer, "__init__", "_connection"),
        (RTCIceTransport, "__init__", "_recv"),
        (RTCIceTransport, "__init__", "_send"),
        (RTCIceTransport, "__init__", "_connection"),
        (RTCDtlsTransport, "__init__", "_state"),
        (RTCDtlsTransport, "__init__", "_tx_srtp"),
        (aioice.ice.Connection, "__init__", "_nominated"),
        (aioice.ice.Connection, "__init__", "_queue"),
        (pylibsrtp.Session, "__init__", "_srtp"),
        (RTCSctpTransport, "__init__", "_data_channels"),
        (RTCSctpTransport, "__init__", "_inbound_streams"),
        (RTCSctpTransport, "__init__", "_last_received_tsn"),
        (RTCSctpTransport, "__init__", "_local_tsn"),
        (RTCSctpTransport, "__init__", "_sack_misordered"),
        (RTCSctpTransport, "__init__", "_sack_needed"),
        (RTCSctpTransport, "__init__", "_sack_duplicates"),
        (RTCSctpTransport, "__init__", "_local_verification_tag"),
        (RTCSctpTransport, "__init__", "_advertised_rwnd"),
    ],
)
def test_an_attribute_that_moved_is_named(
    owner: type, method: str, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A version whose objects have a different attribute is refused at start."""
    monkeypatch.setattr(owner, method, lambda _self: None)
    with pytest.raises(StartError, match=name):
        private.check()


def test_a_machine_with_only_loopback_offers_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """127.0.0.1 is offered only if there is no other address."""
    monkeypatch.setattr(private, "_stock_host_addresses", lambda _4, _6: [])
    assert private._host_addresses(True, False) == ["127.0.0.1"]
    monkeypatch.setattr(private, "_stock_host_addresses", lambda _4, _6: ["192.0.2.7"])
    assert private._host_addresses(True, False) == ["192.0.2.7"]


async def test_only_the_peers_inside_use_the_given_network(monkeypatch: pytest.MonkeyPatch) -> None:
    """Peers outside keep aioice's connection, and each peer inside has its own addresses."""
    private.install()
    monkeypatch.setattr(private, "_stock_host_addresses", lambda _4, _6: ["192.0.2.7"])
    made = LiteConnection(UdpHub(0, list), list, SystemClock().now_s, rich_meter())
    with private.reached_by(private.Reach(lambda: made)):
        inside = RTCIceGatherer([])
    with private.reached_by(private.Reach(None, lambda: ["192.0.2.8", "2001:db8::8"])):
        outside = RTCIceGatherer([])
        assert private._host_addresses(True, True) == ["192.0.2.8", "2001:db8::8"]
        assert private._host_addresses(False, True) == ["2001:db8::8"]
    assert private._host_addresses(True, True) == ["192.0.2.7"]
    connection: object = inside._connection
    assert connection is made
    assert inside.getLocalParameters().iceLite
    assert isinstance(outside._connection, aioice.ice.Connection)
    assert not outside.getLocalParameters().iceLite


def test_consent_never_gives_up() -> None:
    """A link with round trips above half a second stays open; our heartbeat detects silence."""
    private.install()
    assert aioice.ice.CONSENT_FAILURES > 1_000_000


OFFERED = (
    "a=extmap:7 " + rtp.TRANSPORT_SEQUENCE + "\r\na=extmap:8 urn:example:unknown\r\n"
    "a=rtcp-fb:96 transport-cc\r\na=rtpmap:63 red/48000/2\r\na=fmtp:63 96/96\r\n"
)


async def _answered(extra: str, formats: str) -> str:
    """Answer an offer of sound with `extra` lines added; return the answer."""
    before = asyncio.all_tasks()
    browser, ours = RTCPeerConnection(), RTCPeerConnection()
    browser.addTransceiver("audio", direction="recvonly")
    offer = (await browser.createOffer()).sdp
    await browser.setLocalDescription(RTCSessionDescription(offer, "offer"))
    offer = browser.localDescription.sdp.replace(" 96 9 0 8\r\n", f" {formats}\r\n", 1) + extra
    transceiver = ours.addTransceiver("audio", direction="sendonly")
    opus = [c for c in RTCRtpSender.getCapabilities("audio").codecs if c.name == "opus"]
    transceiver.setCodecPreferences(opus)
    await ours.setRemoteDescription(RTCSessionDescription(offer, "offer"))
    private.widen(ours, [rtp.TRANSPORT_SEQUENCE])
    await ours.setLocalDescription(await ours.createAnswer())
    answer: str = ours.localDescription.sdp
    await browser.close()
    await ours.close()
    if connecting := asyncio.all_tasks() - before:  # it ends by itself
        await asyncio.wait(connecting, timeout=5)
    return answer


async def test_extras_unknown_to_aiortc_are_negotiated() -> None:
    """The wanted extension, feedback and redundant sound of an offer are accepted."""
    answer = await _answered(OFFERED, "96 63 9 0 8")
    assert f"a=extmap:7 {rtp.TRANSPORT_SEQUENCE}\r\n" in answer
    assert "urn:example:unknown" not in answer
    assert "a=rtcp-fb:96 transport-cc\r\n" in answer
    assert "a=rtpmap:63 red/48000/2\r\n" in answer
    assert "a=fmtp:63 96/96\r\n" in answer
    assert re.search(r"m=audio \d+ \S+ 96 63\r\n", answer)


async def test_extras_that_are_not_offered_are_not_negotiated() -> None:
    """An extension, feedback or redundancy that was not offered is not in the answer."""
    answer = await _answered("", "96 9 0 8")
    assert "transport" not in answer.replace("SAVPF", "")
    assert "red/" not in answer


async def test_redundancy_of_another_codec_is_not_negotiated() -> None:
    """Redundancy for a codec that is not sent is not accepted."""
    answer = await _answered(OFFERED.replace("96/96", "111/111"), "96 63 9 0 8")
    assert "red/" not in answer


class Sctp:
    """Counts the acknowledgements of an association."""

    def __init__(self) -> None:
        self.sent = 0
        self.state = "connected"
        private_association.delay_acknowledgements(
            cast("RTCSctpTransport", self), rtcsctptransport.SackChunk, 0.02
        )

    async def _send_sack(self) -> None:
        """Stand in for aiortc's."""

    async def _send_chunk(self, chunk: object) -> None:
        self.sent += isinstance(chunk, rtcsctptransport.SackChunk)


async def test_acknowledgements_are_delayed_and_merged() -> None:
    """Messages within the delay are acknowledged once, and later ones again."""
    sctp = Sctp()
    for number in (1, 2):
        for _ in range(3):
            await sctp._send_sack()
        await asyncio.sleep(0.06)
        assert sctp.sent == number


async def test_a_long_message_is_acknowledged_at_once() -> None:
    """A burst is acknowledged at once, other messages after the delay."""
    sctp = Sctp()
    for packets, acknowledged in ((3, 0), (1, 1), (3, 1), (1, 2), (1, 2)):
        for _ in range(packets):
            await sctp._send_sack()
        assert sctp.sent == acknowledged
    await asyncio.sleep(0.06)
    assert sctp.sent == 3


async def test_nothing_is_acknowledged_after_closing() -> None:
    """A due acknowledgement is dropped after closing, as the transport below may be closing."""
    sctp = Sctp()
    await sctp._send_sack()
    sctp.state = "closed"
    await asyncio.sleep(0.06)
    assert sctp.sent == 0


async def test_a_datagrams_cost_is_charged_before_the_next_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """All of aiortc's work on a datagram is charged, and the next is read only within budget."""
    private.install()
    worked_s = 0.0
    monkeypatch.setattr(time, "thread_time", lambda: worked_s)
    meter = rich_meter()
    charged: list[float] = []
    monkeypatch.setattr(meter, "charge", lambda began_s: charged.append(worked_s - began_s))
    gate = asyncio.Event()
    monkeypatch.setattr(meter, "enter", gate.wait)
    datagrams = [b"first", b"second"]

    async def receive() -> bytes:
        return datagrams.pop(0)

    pc = RTCPeerConnection()
    ice = pc.addTransceiver("video").receiver.transport.transport
    monkeypatch.setattr(ice, "_recv", receive)
    private.meter_receiving(pc, meter)
    gate.set()
    assert await ice._recv() == b"first"
    gate.clear()
    worked_s = 0.004
    second = asyncio.ensure_future(ice._recv())
    await asyncio.sleep(0)
    assert charged == [0.004]
    assert datagrams == [b"second"]
    gate.set()
    assert await second == b"second"
    await pc.close()


@pytest.fixture
async def metered(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Metered]:
    private.install()
    made = Metered(RTCPeerConnection(), monkeypatch)
    yield made
    await made.pc.close()


class Metered:
    """A peer whose messages each take `message_s` of processor time, and what it was charged."""

    message_s = 0.0004

    def __init__(self, pc: RTCPeerConnection, monkeypatch: pytest.MonkeyPatch) -> None:
        self.worked_s, self.heard = 0.0, 0
        self.charged_s: list[float] = []
        self.pc = pc
        monkeypatch.setattr(time, "thread_time", lambda: self.worked_s)
        meter = rich_meter()
        monkeypatch.setattr(
            meter, "charge", lambda began_s: self.charged_s.append(self.worked_s - began_s)
        )
        pc.createDataChannel("state")
        sctp: Any = pc.sctp
        self._sctp, self._ice = sctp, sctp.transport.transport
        monkeypatch.setattr(self._ice, "_recv", self._receive)
        monkeypatch.setattr(sctp, "_receive", self._hear)
        private.meter_receiving(pc, meter)

    async def datagram(self, messages: int) -> None:
        """Receive and handle a datagram that brings, or completes, this many messages."""
        await self._ice._recv()
        for _ in range(messages):
            await self._sctp._receive(0, 51, b"x")

    async def _receive(self) -> bytes:
        return b"a datagram"

    async def _hear(self, *_message: object) -> None:
        self.worked_s += self.message_s
        self.heard += 1


async def test_the_messages_of_a_datagram_share_passes(metered: Metered) -> None:
    """A datagram that completes many messages pays for a few at a time, and others go on."""
    handling = asyncio.ensure_future(metered.datagram(6))
    for count in (2, 4, 6):
        await asyncio.sleep(0)
        assert metered.heard == count
    await handling
    assert metered.charged_s == pytest.approx([0.0008] * 2)


async def test_a_message_alone_waits_for_no_pass(metered: Metered) -> None:
    """An operator's commands, one a datagram, are handled as soon as they are read."""
    metered.message_s = 0.001

    async def commands() -> None:
        for _ in range(3):
            await metered.datagram(1)

    handling = asyncio.ensure_future(commands())
    await asyncio.sleep(0)
    assert metered.heard == 3
    await handling


async def test_a_flood_over_full_ice_is_bounded_and_its_checks_charged(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The newest unread datagrams are kept; over budget, no check is answered."""
    private.install()
    meter = rich_meter()
    pc = RTCPeerConnection()
    ice = pc.addTransceiver("video").receiver.transport.transport
    private.meter_receiving(pc, meter)
    protocol = aioice.ice.StunProtocol(ice._connection)
    protocol.local_candidate = aioice.Candidate("1", 1, "udp", 1, "192.0.2.1", 9, "host")
    for number in range(1000):
        protocol.datagram_received(b"%d" % number, ("192.0.2.2", 9))
    assert ice._connection._queue.qsize() == 128
    assert ice._connection._queue.get_nowait() == (b"872", 1)

    asked: list[bytes] = []
    monkeypatch.setattr(
        ice._connection, "request_received", lambda message, *_: asked.append(bytes(message))
    )
    check = bytes(aioice.stun.Message(aioice.stun.Method.BINDING, aioice.stun.Class.REQUEST))
    charged: list[float] = []
    monkeypatch.setattr(meter, "charge", charged.append)
    protocol.datagram_received(check, ("192.0.2.2", 9))
    monkeypatch.setattr(Meter, "is_open", False)
    protocol.datagram_received(check, ("192.0.2.2", 9))
    assert asked == [check]
    assert len(charged) == 1
    await pc.close()


async def test_a_direct_path_is_preferred_to_the_relay(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Checks from our relay wait for less than a second, but not if everything must be relayed."""
    private.install()
    heard: list[str] = []
    later: list[Callable[[], None]] = []
    clock = [100.0]
    monkeypatch.setattr("time.monotonic", lambda: clock[0])
    monkeypatch.setattr(
        asyncio.get_running_loop(), "call_later", lambda _, do, *it: later.append(partial(do, *it))
    )
    check = bytes(aioice.stun.Message(aioice.stun.Method.BINDING, aioice.stun.Class.REQUEST))

    def comes(policy: str, kind: str, *, is_chosen: bool = False, n: int = 1) -> list[str]:
        """Return which checks are handled at once, and which once the delay is over."""
        heard.clear()
        later.clear()
        ice = aioice.ice.Connection(
            ice_controlling=False, transport_policy=aioice.ice.TransportPolicy[policy]
        )
        monkeypatch.setattr(ice, "request_received", lambda *_: heard.append("heard"))
        protocol = aioice.ice.StunProtocol(ice)
        protocol.local_candidate = aioice.Candidate("1", 1, "udp", 1, "192.0.2.1", 9, kind)
        for _ in range(n):
            protocol.datagram_received(check, ("192.0.2.2", 9))
        heard.append("later")
        if is_chosen:
            ice._nominated[1] = aioice.ice.CandidatePair(protocol, protocol.local_candidate)
        clock[0] += 2 * private.RELAY_AFTER_S
        for do in later:
            do()
        return heard

    assert comes("ALL", "host") == ["heard", "later"]
    assert comes("RELAY", "relay") == ["heard", "later"]
    assert comes("ALL", "relay") == ["later", "heard"]
    assert comes("ALL", "relay", is_chosen=True) == ["later"]
    assert comes("ALL", "relay", n=1000) == ["later", *["heard"] * private.MOST_HELD]
