"""A real peer on loopback: media, channels, keyframe requests and its end."""

from __future__ import annotations

import asyncio
import gc
import re
import struct
import weakref
from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any, Literal

import pytest
from aiortc import RTCPeerConnection
from aiortc.rtp import (
    RtcpPacket,
    RtcpPsfbPacket,
    RtcpReceiverInfo,
    RtcpRrPacket,
    RtcpRtpfbPacket,
    RtcpSrPacket,
    RtpPacket,
    is_rtcp,
)
from aiortc.sdp import SessionDescription
from tests.rtc.networks import network, opened_network
from tests.rtc.real_peer import (
    ELSEWHERE,
    Events,
    Noted,
    Pictures,
    Sounds,
    agree,
    agree_on_ours,
    peer_of,
)
from tests.until import async_until

from wax.congestion.control import CongestionControl
from wax.encode.encoded import EncodedSound
from wax.errors import SignallingError
from wax.rtc import private, rtp
from wax.rtc.one_port import lite_agent
from wax.rtc.signalling import clean_offer
from wax.streams.interface import Codecs

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Sequence

    from wax.rtc.one_port.lite_agent import Path as LocalPath
    from wax.rtc.peer import Peer


@dataclass
class Pair:
    """A peer of ours and the browser's side of it."""

    events: Events
    peer: Peer
    browser: RTCPeerConnection
    channels: dict[str, Any]
    lane: Pictures
    congestion: Noted


MODES = [("vp8", "one-port"), ("h264", "full-ice")]
in_both_modes = pytest.mark.parametrize("pair", MODES, ids="-".join, indirect=True)


@pytest.fixture(params=[MODES[0], pytest.param(MODES[1], marks=pytest.mark.full)], ids="-".join)
async def pair(request: pytest.FixtureRequest) -> AsyncIterator[Pair]:
    codec: Literal["vp8", "h264"]
    codec, mode = request.param
    async with opened_network(mode) as opened:
        lane, congestion, events = Pictures(), Noted(), Events()
        browser = RTCPeerConnection()
        browser.addTransceiver("audio", direction="recvonly")
        browser.addTransceiver("video", direction="recvonly")
        channels = {
            "drive": browser.createDataChannel("drive", ordered=False, maxRetransmits=0),
            "state": browser.createDataChannel("state"),
        }
        codecs = Codecs(audio="opus", video=codec)
        peer = peer_of(opened, events, codecs=codecs, video=lane, congestion=congestion)
        made = Pair(events, peer, browser, channels, lane, congestion)
        del peer  # the test must hold the only reference
        await agree(made.peer, browser)
        await events.wait("ready")
        await async_until(lambda: all(one.readyState == "open" for one in channels.values()))
        yield made
        await made.peer.close()
        await browser.close()


@in_both_modes
async def test_messages_go_both_ways(pair: Pair) -> None:
    """Text on either channel arrives under that channel's name, and answers come back."""
    got: asyncio.Queue[str] = asyncio.Queue()
    pair.channels["state"].on("message", got.put_nowait)
    pair.channels["drive"].send("up")
    pair.channels["state"].send("join")
    assert await pair.events.wait("received drive") == "up"
    assert await pair.events.wait("received state") == "join"
    pair.peer.send("state", "hello")
    assert await asyncio.wait_for(got.get(), 5) == "hello"


@pytest.mark.parametrize("mode", ["one-port", "full-ice"])
async def test_a_browser_that_cannot_offer_answers_ours(
    mode: Literal["one-port", "full-ice"],
) -> None:
    """It gets picture, sound and both channels; a second answer changes nothing."""
    async with opened_network(mode) as opened:
        events, congestion = Events(), Noted()
        peer = peer_of(opened, events, congestion=congestion)
        browser = RTCPeerConnection()
        channels = [browser.createDataChannel(name) for name in ("drive", "state")]
        offer = await agree_on_ours(peer, browser)
        await events.wait("ready")
        assert offer.count(f" {rtp.TRANSPORT_SEQUENCE}\r\n") == 2
        await async_until(lambda: channels[0].readyState == "open")
        channels[0].send("up")
        assert await events.wait("received drive") == "up"
        assert await events.wait("clock video")
        assert await events.wait("clock audio")
        assert congestion.sent_bytes
        with pytest.raises(SignallingError):
            await peer.accept(clean_offer(browser.localDescription.sdp))
        assert peer.is_alive
        await peer.close()
        await browser.close()


async def test_an_answer_that_cannot_be_used_ends_the_peer() -> None:
    """An answer to another offer gets a sentence, and nothing is left of the peer."""
    async with opened_network("one-port") as opened:
        events = Events()
        peer = peer_of(opened, events)
        await peer.offer()
        browser = RTCPeerConnection()
        browser.addTransceiver("audio", direction="recvonly")
        await browser.setLocalDescription(await browser.createOffer())
        with pytest.raises(SignallingError):
            await peer.accept(browser.localDescription.sdp)
        assert not peer.is_alive
        assert await events.wait("closed") is None
        await browser.close()


async def test_a_keyframe_leaves_in_several_passes(
    pair: Pair, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However large a picture is, commands and Stop are served between its packets."""
    sender, together = pair.peer._senders["video"], list[int]()

    def kept(packets: Sequence[bytes], *, is_rtcp: bool = False) -> list[int]:
        if not is_rtcp:
            together.append(len(packets))
        return [len(packet) for packet in packets]

    await pair.events.wait("clock video")
    monkeypatch.setattr(sender._egress, "send", kept)
    monkeypatch.setattr(
        pair.lane, "_next", lambda: (b"\0\0\0\x01\x41" + b"\x80" * 50_000, 90_000, 5.0)
    )
    await async_until(lambda: sum(together) >= 50)
    assert max(together) <= 16


@in_both_modes
async def test_the_rtp_clock_is_the_one_on_the_wire(
    pair: Pair, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Capture times computed from the reported RTP clock are those of the packets on the wire."""
    told = await pair.events.wait("clock video")
    assert isinstance(told, tuple)
    rtp, captured_s = told
    sender, lane = pair.peer._senders["video"], pair.lane
    left: list[tuple[RtpPacket, int]] = []

    def kept(packets: Sequence[bytes], *, is_rtcp: bool = False) -> list[int]:
        if not is_rtcp:
            left.extend((RtpPacket.parse(packet), lane.number) for packet in packets)
        return [len(packet) for packet in packets]

    monkeypatch.setattr(sender._egress, "send", kept)
    await async_until(lambda: any(packet.ssrc == sender._ssrc for packet, _ in left))
    packet, number = next(one for one in left if one[0].ssrc == sender._ssrc)
    elapsed_s = (packet.timestamp - rtp) % 2**32 / 90_000
    assert captured_s + elapsed_s == pytest.approx(5 + number / 100, abs=1e-6)
    media_time = pair.peer.media_time("video", packet.timestamp)
    assert media_time == round((captured_s + elapsed_s) * 90_000)
    assert pair.peer.rtp_time("video", media_time) == packet.timestamp


def _wire(pair: Pair, monkeypatch: pytest.MonkeyPatch) -> asyncio.Queue[bytes]:
    """Collect what both senders send in future, before it is protected."""
    wire: asyncio.Queue[bytes] = asyncio.Queue()

    def kept(packets: Sequence[bytes], *, is_rtcp: bool = False) -> list[int]:
        for packet in packets:
            wire.put_nowait(packet)
        return [len(packet) for packet in packets]

    for sender in pair.peer._senders.values():
        monkeypatch.setattr(sender._egress, "send", kept)
    return wire


async def _asked_ten_times(pair: Pair, monkeypatch: pytest.MonkeyPatch) -> list[bytes]:
    """Send ten NACKs for one packet; return the copies that were sent."""
    sender = pair.peer._picture
    wire = _wire(pair, monkeypatch)
    while (packet := RtpPacket.parse(await asyncio.wait_for(wire.get(), 5))).ssrc != sender._ssrc:
        pass
    asked = RtcpRtpfbPacket(fmt=1, ssrc=1, media_ssrc=sender._ssrc, lost=[packet.sequence_number])
    number = packet.sequence_number.to_bytes(2, "big")
    copies = []
    monkeypatch.setattr(sender, "_round_trip_s", lambda: 60.0)
    for _ in range(10):
        await sender.transport._handle_rtcp_data(bytes(asked))
        await async_until(lambda: not sender._requested)
    while not wire.empty():
        data = wire.get_nowait()
        if is_rtcp(data):
            continue
        copy = RtpPacket.parse(data)
        if copy.ssrc == sender._rtx_ssrc and copy.payload == number + packet.payload:
            copies.append(data)
    return copies


async def test_a_lost_packet_is_retransmitted_once_per_round_trip(
    pair: Pair, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A browser that requests one packet ten times gets one copy, not ten."""
    assert len(await _asked_ten_times(pair, monkeypatch)) == 1


async def test_a_full_link_gets_no_retransmissions(
    pair: Pair, monkeypatch: pytest.MonkeyPatch
) -> None:
    """If congestion control refuses, a lost packet is not retransmitted."""
    monkeypatch.setattr(pair.congestion, "may_retransmit", lambda *_: False)
    assert await _asked_ten_times(pair, monkeypatch) == []


@pytest.mark.parametrize("pair", MODES[:1], ids="-".join, indirect=True)
async def test_a_browser_that_changes_its_address_continues(
    pair: Pair, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Data from the browser's new address moves all its traffic there, without a new offer."""
    monkeypatch.setattr(lite_agent, "_QUIET_S", 0.0)
    hub = pair.peer._network._hub
    receive, send = hub.received, hub.send
    home = next(iter(hub._paths)).host

    def received(number: int, data: bytes, _host: str, port: int) -> None:
        if not data.startswith(b"\0\1"):  # not one of ICE's checks
            receive(number, data, ELSEWHERE, port)

    def sent(path: LocalPath, data: bytes) -> None:
        if path.host == ELSEWHERE:
            send(path._replace(host=home), data)

    monkeypatch.setattr(hub, "received", received)
    monkeypatch.setattr(hub, "send", sent)
    forgotten: list[str] = []
    monkeypatch.setattr(pair.peer._tap, "forget", lambda: forgotten.append("in flight"))
    got: asyncio.Queue[str] = asyncio.Queue()
    pair.channels["state"].on("message", got.put_nowait)
    pair.channels["drive"].send("from elsewhere")
    assert await pair.events.wait("received drive") == "from elsewhere"
    await pair.events.wait("network_changed")
    assert forgotten == ["in flight"]
    pair.peer.send("state", "hello")
    assert await asyncio.wait_for(got.get(), 5) == "hello"


async def test_only_a_connected_browser_can_move(pair: Pair) -> None:
    """A browser that is not connected has not moved: it may try one address after another."""
    await pair.peer.close()
    pair.peer._network_changed()
    assert "network_changed" not in dict(pair.events.seen)


async def test_a_closed_link_holds_pictures_but_not_sound(pair: Pair) -> None:
    """While the link is not free, no picture leaves; sound continues."""
    pair.congestion.closed = True
    await asyncio.sleep(0.05)
    pictures, sounds = pair.lane.number, pair.peer._senders["audio"]._packets
    await async_until(lambda: pair.peer._senders["audio"]._packets > sounds + 5)
    assert pair.lane.number == pictures
    pair.congestion.closed = False
    await async_until(lambda: pair.lane.number > pictures)


@in_both_modes
async def test_every_datagram_is_counted(pair: Pair) -> None:
    """Sound, pictures, reports and messages all count against the budget, including headers."""
    pair.congestion.sent_bytes.clear()
    pair.peer.send("state", "x" * 500)

    def sent(*, is_media: bool) -> list[int]:
        return [size for size, of_media in pair.congestion.sent_bytes if of_media is is_media]

    await async_until(lambda: max(sent(is_media=False), default=0) > 500 + 28)
    await async_until(lambda: len(sent(is_media=True)) >= 4)
    assert min(sent(is_media=True)) > 65 + 12 + 28


async def test_a_stream_without_feedback_is_counted_so(
    pair: Pair, monkeypatch: pytest.MonkeyPatch
) -> None:
    """If the browser gives feedback on pictures alone, none is expected on sound and reports."""
    assert pair.congestion.told_bytes == []
    monkeypatch.setattr(pair.peer._picture, "_ids", rtp.ExtensionIds(transport_sequence=7))
    pair.congestion.sent_bytes.clear()
    sounds = pair.peer._senders["audio"]._packets
    await async_until(lambda: len(pair.congestion.told_bytes) > 1)
    await async_until(lambda: pair.peer._senders["audio"]._packets > sounds + 1)
    all_bytes = [size for size, _ in pair.congestion.sent_bytes]
    assert len(pair.congestion.told_bytes) < len(all_bytes)
    # The extension of eight bytes makes them longer than sound that has the same payload.
    assert min(pair.congestion.told_bytes) > min(all_bytes)


async def test_losses_are_reported_per_stream(pair: Pair) -> None:
    """A receiver report's loss is attributed to the stream it is about, sound or picture."""
    peer = pair.peer
    for sender, fraction in ((peer._senders["audio"], 64), (peer._picture, 32)):
        about = RtcpReceiverInfo(sender._ssrc, fraction, 9, 1, 0, 0, 0)
        await sender.transport._handle_rtcp_data(bytes(RtcpRrPacket(ssrc=1, reports=[about])))
    assert pair.congestion.lost_[-2:] == [("audio", 0.25), ("video", 0.125)]


async def test_sound_repeats_earlier_sound(pair: Pair, monkeypatch: pytest.MonkeyPatch) -> None:
    """Earlier sound is repeated with later packets if the browser accepts that (RFC 2198)."""
    sender = pair.peer._senders["audio"]
    wire = _wire(pair, monkeypatch)
    monkeypatch.setattr(sender, "_extra_payload_type", 63)
    lane = pair.peer._senders["audio"]._source
    assert isinstance(lane, Sounds)
    lane.again = (EncodedSound(b"before", 90_000 * 5 + 900 * lane.number, 5.0, 900),)
    while True:
        data = await asyncio.wait_for(wire.get(), 5)
        if is_rtcp(data):
            continue
        read = RtpPacket.parse(data)
        if read.ssrc == sender._ssrc and read.payload_type == 63:
            break
    assert b"before" in read.payload


async def test_the_lane_learns_of_missing_redundancy(pair: Pair) -> None:
    """If the offer has no redundant sound, the lane learns that none will be sent."""
    lane = pair.peer._senders["audio"]._source
    assert isinstance(lane, Sounds)
    assert lane.takes_redundancy is False


async def test_a_sender_report_has_the_time_of_capture(
    pair: Pair, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A sender report pairs its time with the RTP time of what is captured then, not sent then."""
    sender = pair.peer._picture
    wire = _wire(pair, monkeypatch)
    # The newest picture left just now and was captured a second ago.
    set_s = monotonic()
    monkeypatch.setattr(sender, "_newest", (450_000, set_s - 1.0))
    monkeypatch.setattr(sender, "_note_sent", lambda *_: None)
    while True:
        data = await asyncio.wait_for(wire.get(), 5)
        report = RtcpPacket.parse(data)[0] if is_rtcp(data) else None
        if isinstance(report, RtcpSrPacket) and report.ssrc == sender._ssrc:
            break
    elapsed_s = (report.sender_info.rtp_timestamp - sender.origin - 450_000) % 2**32 / 90_000
    assert 1.0 <= elapsed_s <= 1.0 + monotonic() - set_s


async def test_feedback_reaches_congestion_control(pair: Pair) -> None:
    """The browser's feedback is matched with the packets that were sent."""
    tap = pair.peer._tap
    number = tap.number_packet(100, monotonic(), kind="audio", train=None)
    assert number is not None
    # One packet, received 0.25 ms after the reference time (draft-holmer-rmcat, 3.1).
    feedback = struct.pack("!BBHLLHHLHBB", 0x8F, 205, 5, 1, 2, number, 1, 1 << 8, 1 << 13 | 1, 1, 0)
    await pair.peer._senders["audio"].transport._handle_rtcp_data(feedback)
    told = [one for one in pair.congestion.delivered_ if one.kind == "audio"]
    assert told
    assert told[-1].arrived_s is not None


async def test_unreadable_feedback_is_reported(pair: Pair) -> None:
    """Feedback that announces more than it contains is reported as refused, and the peer lives."""
    feedback = struct.pack("!BBHLLHHLH", 0x8F, 205, 4, 1, 2, 7, 500, 1 << 8, 1 << 13 | 1)
    await pair.peer._senders["audio"].transport._handle_rtcp_data(feedback.ljust(20, b"\0"))
    await pair.events.wait("feedback refused")
    assert pair.peer.is_alive


async def test_a_failing_sender_report_ends_the_peer(
    pair: Pair, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A sender whose reports fail does not linger: its peer ends, and the viewer reconnects."""

    def broken(**_: object) -> bytes:
        raise ValueError("no report")

    monkeypatch.setattr(rtp, "sender_report", broken)
    for _ in range(250):
        if not pair.peer.is_alive:
            break
        await asyncio.sleep(0.02)
    assert not pair.peer.is_alive


async def test_a_lost_picture_asks_for_a_keyframe(pair: Pair) -> None:
    """A PLI, which aiortc ignores for packet tracks, reaches the encoder."""
    sender = pair.peer._picture
    asked = RtcpPsfbPacket(fmt=1, ssrc=1, media_ssrc=sender._ssrc)
    await sender.transport._handle_rtcp_data(bytes(asked))
    await pair.events.wait("keyframe")


@in_both_modes
async def test_a_closing_page_is_noticed_at_once(pair: Pair) -> None:
    """When the page closes its peer, ours closes too and reports that once."""
    await pair.browser.close()
    await pair.events.wait("closed")
    await pair.peer.close()
    assert [what for what, _ in pair.events.seen].count("closed") == 1
    assert not pair.peer.is_alive


async def test_a_close_that_fails_still_ends_the_peer(
    pair: Pair, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever aiortc raises on closing, the viewer learns that their peer is gone."""
    close = pair.peer._pc.close

    async def failing() -> None:
        await close()
        raise OSError("half closed")

    monkeypatch.setattr(pair.peer._pc, "close", failing)
    await pair.peer.close()
    await pair.events.wait("closed")


async def test_no_outside_host_is_contacted() -> None:
    """Without configured ICE servers there are none, not aiortc's public default."""
    peer = peer_of(network(), Events(), congestion=CongestionControl())
    connection = peer._senders["video"].transport.transport.iceGatherer._connection
    await peer.close()
    assert (connection.stun_server, connection.turn_server) == (None, None)


async def test_nothing_is_sent_after_the_end(pair: Pair) -> None:
    """Sending to a closed peer is no error."""
    await pair.peer.close()
    pair.peer.send("state", "late")


@in_both_modes
@pytest.mark.parametrize("state", ["unanswered", "connected", "unsent"])
async def test_a_closed_peer_is_freed_at_once(pair: Pair, state: str) -> None:
    """A closed peer is freed without the garbage collector, whose full run stops the event loop."""
    if state != "unanswered":
        peer, pair.peer, pair.events = pair.peer, peer_of(network(), Events()), Events()
    else:
        peer = peer_of(network(), Events())
        await peer.answer(clean_offer(_offer("chromium")))
    pc = peer._pc
    parts = [pc, pc.sctp, *pc.getTransceivers(), *pc.getSenders(), *pc.getReceivers()]
    left = [weakref.ref(one) for one in (*parts, peer, pc.getReceivers()[0].transport)]
    gc.disable()
    try:
        if state == "unsent":
            for _ in range(300):
                peer.send("state", "x" * 1000)
        await peer.close()
        del peer, pc, parts
        for _ in range(200):  # tasks end on later passes of the event loop
            if any(one() is not None for one in left):
                await asyncio.sleep(0.05)
        assert [one() for one in left if one() is not None] == []
    finally:
        gc.enable()


async def test_no_keys_are_made_for_whoever_never_comes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Peers whose browser never connects may end in great numbers at once."""
    made: list[object] = []
    make = private._stock_ssl_context

    def noted(*of: Any, **how: Any) -> object:
        made.append(of)
        return make(*of, **how)

    async with opened_network("one-port") as opened:
        peer = peer_of(opened, Events())
        monkeypatch.setattr(private, "_stock_ssl_context", noted)
        await peer.answer(clean_offer(_offer("chromium")))
        pc = peer._pc
        await async_until(lambda: pc.iceConnectionState == "checking")
        dtls = pc.getSenders()[0].transport
        await peer.close()
        await async_until(lambda: dtls.state == "failed")
    assert made == []


def _offer(browser: str) -> str:
    return (Path(__file__).parent / "offers" / f"{browser}.sdp").read_text(encoding="utf-8")


@pytest.mark.parametrize("browser", ["chromium", "firefox", "safari"])
async def test_a_browsers_offer_is_answered_and_parsed_once(
    browser: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The answer has all three sections, and the offer is parsed only once."""
    parsed: list[str] = []
    parse = SessionDescription.parse

    def noted(text: str) -> SessionDescription:
        parsed.append(text)
        return parse(text)

    monkeypatch.setattr(SessionDescription, "parse", noted)
    offer = clean_offer(_offer(browser))
    peer = peer_of(network(), Events())
    answer = await peer.answer(offer)
    await peer.close()
    assert parsed.count(offer) == 1
    assert len(re.findall(r"^m=(audio|video|application) [1-9]", answer, re.MULTILINE)) == 3
    assert f"{rtp.TRANSPORT_SEQUENCE}\r\n" in answer


async def test_garbage_is_refused_with_a_sentence() -> None:
    """An offer that aiortc cannot parse is refused, and leaves nothing open."""
    events = Events()
    peer = peer_of(network(), events, congestion=CongestionControl())
    sections = [f"m={kind} 9 UDP/TLS/RTP/SAVPF x" for kind in ("audio", "video", "application")]
    with pytest.raises(SignallingError, match="cannot answer"):
        await peer.answer("\r\n".join(["v=0", *sections]))
    assert not peer.is_alive
    assert events.seen == [("closed", None)]


@pytest.mark.parametrize(("at_once", "most_10ms"), [(True, 0), (False, 51)])
async def test_firefox_gets_a_range_of_playout_delays(
    pair: Pair, *, at_once: bool, most_10ms: int
) -> None:
    """Firefox, which does not report pictures shown at once, gets a range of playout delays."""
    picture = pair.peer._picture
    picture.shows_at_once = at_once
    pair.peer.set_playout_delay(0)
    assert picture._playout_delay == rtp.PlayoutDelay(0, most_10ms)
    pair.peer.set_playout_delay(50)
    assert picture._playout_delay == rtp.PlayoutDelay(5, 5)
