"""A peer that publishes: its offer, and how it measures silence."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from aiortc.rtp import RtcpPacket, RtcpSrPacket
from tests.turned_clock import TurnedClock

from wax.encode.encoded import EncodedPicture
from wax.errors import SignallingError
from wax.fanout.sound_lane import BoundedSoundLane
from wax.fanout.video_lane import VideoLane
from wax.rtc import rtp
from wax.rtc.offer_extensions import with_extensions
from wax.rtc.publisher import Publisher
from wax.streams.interface import Codecs

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Sequence

OFFER = "v=0\r\nm=video 9 x 96 97\r\na=mid:0\r\na=rtpmap:96 VP8/90000\r\na=rtpmap:97 rtx/90000\r\n"


@pytest.fixture
def clock() -> TurnedClock:
    return TurnedClock()


@pytest.fixture
async def publisher(clock: TurnedClock) -> AsyncIterator[Publisher]:
    made = Publisher(
        codecs=Codecs("opus", "vp8"),
        video=VideoLane(),
        audio=BoundedSoundLane(),
        clock=clock,
        on_keyframe_wanted=lambda: None,
    )
    yield made
    await made.close()


async def test_it_offers_one_codec_of_each_and_the_capture_time(publisher: Publisher) -> None:
    """The offer has no feedback, which would come too late, and nothing that is not sent."""
    offer = await publisher.offer()
    names = [line.split()[1].split("/")[0] for line in offer.splitlines() if "rtpmap" in line]
    assert set(names) == {"opus", "VP8", "rtx"}
    assert offer.count(rtp.CAPTURE_TIME) == 2
    assert "transport-cc" not in offer
    assert offer.count("a=sendonly") == 2


async def test_an_invalid_answer_raises(publisher: Publisher) -> None:
    """An answer that is no session description raises `SignallingError`."""
    await publisher.offer()
    with pytest.raises(SignallingError, match="cannot be used"):
        await publisher.accept("<html>")


def test_feedback_is_offered_with_transport_numbers() -> None:
    """Feedback is offered for the codec, not for its retransmissions."""
    offer = with_extensions(OFFER, (rtp.TRANSPORT_SEQUENCE, rtp.PLAYOUT_DELAY))
    assert f"a=extmap:5 {rtp.TRANSPORT_SEQUENCE}\r\na=extmap:6 {rtp.PLAYOUT_DELAY}" in offer
    assert "a=rtcp-fb:96 transport-cc" in offer
    assert "a=rtcp-fb:97" not in offer


async def test_silence_is_sending_without_reports(publisher: Publisher, clock: TurnedClock) -> None:
    """Silence counts from the first unreported packet; a source that sends nothing causes none."""
    (picture,) = (one for one in publisher._senders if one.kind == "video")

    def send(seconds: int) -> None:
        for _ in range(seconds):
            publisher._on_sent("video")
            clock.time_s += 1.0
        publisher._on_sent("video")

    assert publisher.unheard_s == 0.0
    send(3)
    assert publisher.unheard_s == 3.0
    picture.heard_s = clock.time_s
    assert publisher.unheard_s == 0.0
    clock.time_s += 60.0  # the camera fails
    assert publisher.unheard_s == 0.0
    send(2)
    assert publisher.unheard_s == 2.0


async def test_setting_the_clock_shifts_no_capture_time(
    publisher: Publisher, clock: TurnedClock, monkeypatch: pytest.MonkeyPatch
) -> None:
    """When the wall clock jumps by hours, sound and picture stay in sync and their ages true."""
    captured: set[int | None] = set()
    reported: set[int] = set()
    picture = EncodedPicture(b"x", 1, "r", True, 0, clock.now_s())

    def leave(packets: Sequence[bytes], *_: object, **__: object) -> None:
        report = RtcpPacket.parse(packets[0])[0]
        assert isinstance(report, RtcpSrPacket)
        reported.add(report.sender_info.ntp_timestamp)

    for wall_ms in (0, 3_600_000, -3_600_000):
        monkeypatch.setattr(clock, "wall_ms", lambda now_ms=wall_ms: now_ms)
        for sender in publisher._senders:
            monkeypatch.setattr(sender, "_ids", rtp.ExtensionIds(capture_time=5))
            monkeypatch.setattr(sender, "_send_datagrams", leave)
            captured.add(sender._captured_ntp(picture))
            sender._send_report(0, picture.captured_s)
    assert captured == reported
    assert len(captured) == 1
