"""The client's clock, reports and commands, as decoded by the server's codec."""

from __future__ import annotations

import asyncio
import json
from typing import TYPE_CHECKING

import pytest

from wax.client import Operator
from wax.client.clock import ServerClock
from wax.client.media import FrameArrival, StreamCounts
from wax.client.reports import ReceivedStream, Reporter
from wax.client.sdp import agreed, as_browser
from wax.protocol.compact import write
from wax.protocol.messages import Drive, Report, parse_drive
from wax.rtc.signalling import clean_offer

if TYPE_CHECKING:
    from collections.abc import AsyncIterator


@pytest.fixture
async def operator() -> AsyncIterator[Operator]:
    operator = Operator("http://127.0.0.1:9")
    yield operator
    await operator.close()


async def test_a_command_is_what_the_hands_hold(operator: Operator) -> None:
    """Each field of a command is where the server reads it, and `other` replaces fields."""
    operator.steer(0.5, -0.25)
    operator.clock.add(1000.0, 1002.0, 6001.0)
    command = parse_drive(operator.row(operator.next_seq()))
    assert isinstance(command, Drive)
    assert (command.seq, command.turn, command.held, command.speed) == (1, 0, True, "fast")
    assert (command.linear, command.angular, command.seen_server_ms) == (0.5, -0.25, None)
    assert command.sent_server_ms == pytest.approx(operator.server_ms(), abs=1000)
    other = parse_drive(operator.row(7, linear=-1.0, turn=3))
    assert isinstance(other, Drive)
    assert (other.seq, other.turn, other.linear, other.angular) == (7, 3, -1.0, -0.25)
    assert len(json.loads(operator.row(8))) == 11  # as before anything moved sideways
    operator.steer(0.5, -0.25, 0.75)
    for row, lateral in ((operator.row(9), 0.75), (operator.row(10, lateral=-1.0), -1.0)):
        aside = parse_drive(row)
        assert isinstance(aside, Drive)
        assert (aside.linear, aside.angular, aside.lateral) == (0.5, -0.25, lateral)
    operator.let_go()
    assert len(json.loads(operator.row(11))) == 11


async def test_an_offer_is_a_browsers(operator: Operator) -> None:
    """The offer has transport-wide feedback for both streams, and the server can parse it."""
    peer = operator.peer
    await peer.setLocalDescription(await peer.createOffer())
    offer = clean_offer(as_browser(peer.localDescription.sdp))
    sound, picture = offer.split("m=audio")[1].split("m=video")
    for section in (sound, picture.split("m=application")[0]):
        assert "transport-cc" in section
        assert agreed(f"m=audio\r\n{section}").extension_id == 5
    assert "transport-cc" not in picture.split("m=application")[1]


async def test_waiting_ends_with_the_news_or_in_time(operator: Operator) -> None:
    """`until` returns as soon as a message makes its condition true, and False after a timeout."""
    waiting = asyncio.create_task(operator.until(lambda: operator.stopped == 3))
    await asyncio.sleep(0)
    operator.state.emit("message", '{"type": "room", "stop": {"number": 3, "by": "Guest 1"}}')
    assert await waiting
    assert not await operator.until(lambda: False, 0.01)


def test_the_quickest_round_trip_aligns_the_clock() -> None:
    """The clock ignores a delay spike in one direction, and forgets old round trips."""
    clock = ServerClock()
    assert (clock.ahead_ms, clock.error_ms) == (0.0, None)
    clock.add(1000.0, 1002.0, 6001.0)
    clock.add(2000.0, 2100.0, 7099.0)
    assert (clock.ahead_ms, clock.one_way_s, clock.error_ms) == (5000.0, 0.001, 1.0)
    for _ in range(32):
        clock.add(3000.0, 3010.0, 8105.0)
    assert clock.ahead_ms == 5100.0


def test_a_report_says_what_arrived_and_what_was_lost() -> None:
    """The sound's reported age is that on arrival plus the target; lost sound is concealed."""
    reporter = Reporter()
    clock = {"type": "rtp_clock", "kind": "audio", "rtp_origin": 2**32 - 480, "rate_hz": 48000}
    reporter.handle(clock | {"origin_server_ms": 50_000.0})
    reporter.handle({"type": "playout", "sound_target_ms": 30.0})
    sound = ReceivedStream(StreamCounts(packets=90, lost=10), FrameArrival(480, 45.06))
    picture = ReceivedStream(StreamCounts(frames=30), FrameArrival(1, 45.0))
    for frames, now_s in ((0, 45.5), (30, 46.5)):
        picture.counts.frames = frames
        report = reporter.report(
            sound=sound, picture=picture, now_s=now_s, ahead_ms=5000.0, clock_error_ms=1.0
        )
    assert report.sound is not None
    assert report.sound.age_ms == pytest.approx(60 - 20 + 30)
    assert report.sound.delay_ms == 30.0
    assert report.picture is not None
    assert report.picture.rate_hz == 30.0
    assert report.sound.concealed_ms == pytest.approx(144.0)
    assert isinstance(parse_drive(write(report)), Report)


def test_reports_are_as_frequent_as_a_pages() -> None:
    """Every report is sent for ten seconds, then one a second, except while driving."""
    reporter = Reporter()
    assert all(reporter.is_due(eager=False) for _ in range(40))
    assert [reporter.is_due(eager=False) for _ in range(40)].count(True) == 10
    assert all(reporter.is_due(eager=True) for _ in range(40))
