"""A viewer: every message is understood or refused, none of them raises."""

from __future__ import annotations

import json
import math
from typing import Any, cast

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.session.viewer_rig import (
    SMALLEST,
    Connected,
    connect,
    drive_row,
    want_message,
)

from wax.config.sync import SyncSettings
from wax.config.video import VideoSettings
from wax.control.reasons import Refusal
from wax.protocol import messages
from wax.streams.live import LiveService, LiveStreams


def test_a_command_becomes_a_value() -> None:
    """A well-formed set-point reaches the room, times in seconds."""
    connected = connect()
    connected.viewer.received("drive", drive_row(seen_server_ms=99_900.0))
    name, command = connected.room.calls[-1]
    assert name == "drive"
    assert (command.seq, command.turn, command.sent_s) == (1, 2, 99.99)
    assert (command.linear, command.angular, command.speed) == (0.5, -1.0, "slow")
    assert command.lateral == 0.0  # such a page knows no sideways
    assert command.seen_s == 99.9
    assert command.held is True
    connected.viewer.received("drive", drive_row(linear=0, angular=0, lateral=-0.25))
    _, command = connected.room.calls[-1]
    assert (command.linear, command.angular, command.lateral) == (0, 0, -0.25)
    assert command.asks_for_motion


@pytest.mark.parametrize(
    "text",
    [
        drive_row(linear=1.01),
        drive_row(linear="0.5"),
        drive_row(seq=-1),
        drive_row(seq=1.5),
        drive_row(lateral=1.01),
        drive_row(lateral=0, extra=1),
        drive_row(type="fly"),
        drive_row(speed="warp"),
        drive_row(sent_server_ms=None),
        drive_row(axes={"pan": 2}),
        drive_row(beat=7),
        drive_row(beat="7 chars"),
        drive_row(axes={str(i): 0 for i in range(5)}),
        drive_row().replace("0.5", "NaN"),
        drive_row().replace("0.5", "1e999"),
        drive_row() + " " * 600,
        "[]",
        "null",
        "",
        "\x00",
        '["join"]',
        '{"type":"join"}',
    ],
)
def test_a_malformed_command_is_refused_and_counted(text: str) -> None:
    """A malformed command moves nothing, is counted, and raises nothing."""
    connected = connect()
    before = list(connected.room.calls)
    connected.viewer.received("drive", text)
    assert connected.room.calls == before
    assert connected.counters.snapshot() == {"messages refused": 1}


def test_a_page_from_before_an_update_is_told_to_reload() -> None:
    """Its commands lack a column; it is told once per connection, not once per command."""
    connected = connect()
    older = json.dumps(json.loads(drive_row())[:-1])
    notice = {"type": "notice", "text": {"code": "request.not_understood"}}

    def told() -> int:
        return connected.room.sent.count(("state", notice))

    for _ in range(3):
        connected.viewer.received("drive", older)
    assert told() == 1
    connected.viewer.make_lanes()
    connected.viewer.ready()
    connected.viewer.received("state", '{"type":"release","stop":1,"sent_server_ms":1.0}')
    assert told() == 2


@given(st.sampled_from(["drive", "state"]), st.text() | st.binary())
def test_no_bytes_raise(channel: Any, data: str | bytes) -> None:
    """Whatever arrives, the handler returns: an exception would close the peer."""
    connected = connect()
    connected.viewer.received(channel, data)
    assert sum(connected.counters.snapshot().values()) == 1


def test_a_failing_room_does_not_close_the_peer() -> None:
    """An error of our own is logged and counted, and the peer lives on."""
    connected = connect()
    connected.room.calls = cast("Any", None)
    connected.viewer.received("state", '{"type":"stop"}')
    assert connected.counters.snapshot() == {"messages failed": 1}


def test_a_ping_is_answered_with_both_clocks() -> None:
    """The pong returns the page's stamp and adds the server's, on the lossy channel."""
    connected = connect()
    connected.viewer.received("drive", '["ping",3,12.5,null,null]')
    channel, (*clocks, beat) = connected.room.sent[-1]
    assert (channel, clocks) == ("drive", ["pong", 3, 12.5, 100_000.0])
    assert len(beat) == 6


def _beats(connected: Connected) -> list[str]:
    rows = [said for channel, said in connected.room.sent if channel == "drive"]
    return [row[-1] for row in rows if row[0] in ("pong", "beat")]


def test_a_command_is_as_old_as_the_beat_that_it_quotes() -> None:
    """The server's time of the quoted beat dates a command; an unknown beat dates nothing."""
    connected = connect()
    connected.viewer.received("drive", '["ping",3,12.5,null,null]')
    connected.clock.time_s += 0.05
    connected.viewer.received("drive", drive_row(beat=_beats(connected)[-1]))
    connected.viewer.received("drive", drive_row(beat="guess_"))
    connected.viewer.received("drive", drive_row(beat=None))
    heard_s = [command.heard_s for name, command in connected.room.calls if name == "drive"]
    assert heard_s == [100.0, -math.inf, -math.inf]


@pytest.mark.parametrize(
    ("claimed_ms", "sent_s", "expected"),
    [
        (99_900.0, 99.95, 99.9),
        (99_990.0, 99.95, 99.95),
        (99_990.0, None, None),
        (None, 99.95, None),
    ],
)
def test_nobody_sees_a_picture_that_was_not_sent(
    claimed_ms: float | None, sent_s: float | None, expected: float | None
) -> None:
    """A page may claim a picture that it does not show, but none newer than was sent to it."""
    connected = connect()
    connected.room.newest_picture_s = sent_s
    connected.viewer.received("drive", drive_row(seen_server_ms=claimed_ms))
    assert connected.room.calls[-1][1].seen_s == expected


def test_a_new_peer_has_no_beat_yet() -> None:
    """A beat from an earlier connection proves nothing on the next one."""
    connected = connect()
    connected.viewer.received("drive", '["ping",3,12.5,null,null]')
    connected.viewer.make_lanes()
    connected.viewer.received("drive", drive_row(beat=_beats(connected)[-1]))
    assert connected.room.calls[-1][1].heard_s == -math.inf


@pytest.mark.parametrize(("is_thin", "heard"), [(False, 10), (True, 5)])
def test_a_page_that_sends_commands_gets_beats(
    is_thin: bool, heard: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It gets ten a second, five over a thin link; other pages get only those in pongs."""
    connected = connect()
    monkeypatch.setattr(LiveStreams, "is_thin", is_thin)
    assert _beats(connected) == []
    for _ in range(50):
        connected.viewer.received("drive", drive_row())
        connected.clock.time_s += 0.02
    assert abs(len(set(_beats(connected))) - heard) <= 2


def test_a_release_is_dated_by_its_beat() -> None:
    """A page cannot date a release of Stop by its arrival."""
    connected = connect()
    connected.viewer.received("drive", '["ping",3,12.5,null,null]')
    connected.clock.time_s += 5.0
    now_ms, beat = connected.clock.time_s * 1000, _beats(connected)[-1]
    late = messages.Release(type="release", stop=1, sent_server_ms=now_ms, beat=beat)
    assert connected.viewer.release_sent_s(late) == pytest.approx(101.35)
    unheard = late.model_copy(update={"beat": None})
    assert connected.viewer.release_sent_s(unheard) == -math.inf
    honest = late.model_copy(update={"sent_server_ms": 100_500.0})
    assert connected.viewer.release_sent_s(honest) == 100.5


def test_a_stop_passes_in_a_flood() -> None:
    """However many messages came before, a Stop with its press counts, and nothing else."""
    connected = connect()
    for _ in range(500):
        connected.viewer.received("state", '{"type":"name","name":"x"}')
    connected.room.calls.clear()
    connected.viewer.received("state", '{"type":"join"}')
    connected.viewer.received("state", "{" * 20)
    connected.viewer.received("drive", '{"type":"stop"}')
    connected.viewer.received("state", '{"type":"stop"}')
    connected.viewer.received("state", f'{{"type":"stop","press":{2**53}}}')
    assert connected.room.calls == [("stop", None), ("stop", 2**53)]


def test_a_release_names_its_stop() -> None:
    """The room learns which Stop is meant."""
    connected = connect()
    release = {"type": "release", "stop": 3, "sent_server_ms": 99_990.0, "beat": None}
    connected.viewer.received("state", json.dumps(release))
    assert connected.room.calls[-1] == ("release", 3)


def test_a_picture_that_is_switched_off_is_known() -> None:
    """A viewer's last request decides whether they want the picture."""
    connected = connect()
    assert connected.viewer.wants_picture
    size = VideoSettings().renditions[0].size
    connected.viewer.received("state", json.dumps(want_message(size) | {"picture": False}))
    assert not connected.viewer.wants_picture


@pytest.mark.parametrize("request_type", ["join", "leave"])
def test_requests_reach_the_room(request_type: str) -> None:
    """Join and leave reach the room with their viewer."""
    connected = connect()
    connected.viewer.received("state", json.dumps({"type": request_type}))
    assert connected.room.calls[-1] == (request_type, 7)


def test_the_picture_plays_unasked_and_the_sound_on_request() -> None:
    """A small picture plays on load; nothing else is sent before it is requested."""
    connected = connect()
    assert connected.video.wanted == [SMALLEST]
    assert connected.audio.wanted == []
    want = want_message("160x120")
    connected.viewer.received("state", json.dumps(want))
    assert connected.video.wanted == [SMALLEST]
    assert len(connected.audio.wanted) == 1
    connected.viewer.received("state", json.dumps(want | {"picture": False, "sound": False}))
    assert connected.video.wanted == []
    assert connected.audio.wanted == []


def test_an_unknown_size_is_refused_with_a_sentence() -> None:
    """A size that does not exist changes nothing; the answer lists those that do."""
    connected = connect()
    want = want_message("9x9") | {"sound": False}
    connected.viewer.received("state", json.dumps(want))
    assert connected.video.wanted == [SMALLEST]
    channel, notice = connected.room.sent[-1]
    assert (channel, notice["type"]) == ("state", "notice")
    assert notice["text"]["code"] == "want.no_size"
    assert "640x480" in notice["text"]["values"]["sizes"]


def test_leaving_ends_encoding_that_nobody_else_wants() -> None:
    """When the last viewer's peer is gone nothing is encoded."""
    connected = connect()
    want = want_message("640x480")
    connected.viewer.received("state", json.dumps(want))
    connected.viewer.release()
    connected.viewer.release()
    assert (connected.video.wanted, connected.audio.wanted) == ([], [])


def test_a_page_in_another_network_gets_its_streams_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    """The room is told first, which stops the robot; and the delay is measured anew."""
    connected = connect()
    connected.viewer.link.handle_ping(1, None, None, 100.0)
    connected.viewer.link.handle_ping(2, 1, 0.0, 100.1)
    assert connected.viewer.link.one_way_s == pytest.approx(0.05)
    calls = connected.room.calls
    streams = connected.viewer.streams
    monkeypatch.setattr(streams, "link_changed", lambda: calls.append(("streams", None)))
    monkeypatch.setattr(streams, "keyframe_wanted", lambda one: calls.append(("keyframe", one)))
    calls.clear()
    connected.viewer.network_changed()
    assert calls == [("moved", 7), ("streams", None), ("keyframe", None)]
    assert connected.viewer.link.one_way_s is None
    assert connected.viewer.link.silence_s(connected.clock.now_s()) == 0


def test_what_the_page_has_received_reaches_its_streams(monkeypatch: pytest.MonkeyPatch) -> None:
    """An acknowledgement is passed on with the media time of the unit's last packet."""
    connected = connect()
    got: list[tuple[str, int]] = []
    monkeypatch.setattr(connected.viewer.streams, "received", lambda *what: got.append(what))
    message = {"type": "received", "kind": "audio", "rtp": 5000}
    connected.viewer.received("state", json.dumps(message))
    assert got == [("audio", 4000)]


def test_the_policy_follows_reports_and_role() -> None:
    """Reports move the picture's hold-back; a new role brings its own policy and media unit."""
    connected = connect(SyncSettings(audio_delay_ms=200.0))
    want = want_message("640x480")
    connected.viewer.received("state", json.dumps(want))
    playout = [m for _, m in connected.room.sent if m["type"] == "playout"]
    assert (playout[-1]["sound_target_ms"], playout[-1]["picture_target_ms"]) == (200.0, 200.0)
    report = '["report",[260,200,null,0,1000,0,"browser"],[215,200,30,0],1]'
    for _ in range(4):
        connected.clock.time_s += 0.25
        connected.viewer.received("drive", report)
    playout = [m for _, m in connected.room.sent if m["type"] == "playout"]
    assert playout[-1]["picture_target_ms"] > 220
    connected.viewer.set_role(SyncSettings(policy="video-first", audio_mu_ms=60), drives=False)
    playout = [m for _, m in connected.room.sent if m["type"] == "playout"]
    assert (playout[-1]["policy"], playout[-1]["picture_target_ms"]) == ("video-first", 0.0)
    assert connected.viewer.streams.status().entry["sound_mu_ms"] == 60


def test_the_viewers_own_choice_of_policy_is_applied() -> None:
    """A page may choose a policy, and leave the choice to the role again."""
    connected = connect()
    for asked, policy in (("video-first", "video-first"), (None, "audio-master")):
        want = want_message("640x480") | {"policy": asked}
        connected.viewer.received("state", json.dumps(want))
        playout = [m for _, m in connected.room.sent if m["type"] == "playout"]
        assert playout[-1]["policy"] == policy


@pytest.mark.parametrize(("is_thin", "least", "most"), [(False, 3, 5), (True, 1, 2)])
def test_the_status_of_commands_is_sent_a_few_times_a_second(
    is_thin: bool, least: int, most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Reasons that change with each command are sent three times a second, and always the last.

    Over a thin link it is once a second.
    """
    connected = connect()
    monkeypatch.setattr(LiveStreams, "is_thin", is_thin)
    for tick in range(40):
        connected.clock.time_s += 0.025
        reason = Refusal.TOO_OLD.value if tick % 2 else None
        connected.viewer.drive_status = messages.DriveStatus(
            moving=not tick % 2, reason=reason, share=1.0
        )
        connected.viewer.send_drive_status(connected.clock.now_s())
    connected.viewer.send_drive_status(connected.clock.now_s() + 1)
    told = [m for _, m in connected.room.sent if m["type"] == "drive_status"]
    assert least <= len(told) <= most
    assert told[-1]["reason"] == Refusal.TOO_OLD.value.wire()


def test_a_missing_camera_cannot_be_chosen() -> None:
    """The page reads that it is missing; an existing one is chosen, however often others are."""
    connected = connect()
    looked: list[dict[str, Any]] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(LiveService, "cameras", ["Door"])
        patch.setattr(connected.viewer.streams, "select_cameras", lambda **how: looked.append(how))
        for large in (0, 1, None):
            look = {"type": "look", "large": large, "small": True}
            connected.viewer.received("state", json.dumps(look))
    assert looked == [{"large": 0, "small": True}, {"large": None, "small": True}]
    assert connected.counters.snapshot()["requests refused"] == 1
    notices = [message for channel, message in connected.room.sent if channel == "state"]
    told = {"code": "want.no_camera", "values": {"number": 2}}
    assert any(one.get("text") == told for one in notices)
