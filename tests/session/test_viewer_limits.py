"""What one page may request, and how often, since the others pay for it."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from tests.session.viewer_rig import connect, drive_row, want_message

from wax.protocol.messages import MAX_DRIVE_BYTES

if TYPE_CHECKING:
    import pytest


def test_keyframes_are_forced_at_a_bounded_rate(monkeypatch: pytest.MonkeyPatch) -> None:
    """A browser that asks a hundred times a second gets a few at first, then one in two seconds."""
    connected = connect()
    asked: list[float] = []
    monkeypatch.setattr(
        connected.viewer.streams,
        "keyframe_wanted",
        lambda _camera: asked.append(connected.clock.time_s),
    )
    for _ in range(6000):
        connected.clock.time_s += 0.01
        connected.viewer.keyframe_wanted()
    assert len(asked) <= 8 + 30
    assert len(asked) >= 30
    refused = connected.counters.snapshot()["keyframes refused"]
    assert len(asked) + refused == 6000


def test_commands_are_accepted_at_a_bounded_rate() -> None:
    """Sixty a second, of at most 256 bytes each, are accepted, which our page never exceeds."""
    connected = connect()
    for seq in range(1000):
        connected.clock.time_s += 0.02
        connected.viewer.received("drive", drive_row(seq=seq))
    assert sum(name == "drive" for name, _ in connected.room.calls) == 1000
    connected.room.calls.clear()
    for seq in range(1000):
        connected.clock.time_s += 0.0105
        connected.viewer.received("drive", drive_row(seq=1000 + seq))
    taken = sum(name == "drive" for name, _ in connected.room.calls)
    assert 630 <= taken <= 630 + 121
    longest = {name * 8: -0.1234567890123456 for name in ("ab", "cd", "ef", "gh")}
    long = drive_row(seq=2**53, turn=2**31, linear=-0.123456789012345, axes=longest)
    assert len(long.replace(" ", "")) <= MAX_DRIVE_BYTES


def test_requests_run_at_a_bounded_rate() -> None:
    """A page that switches sizes without end gets a few changes, and always the last one."""
    connected = connect()
    changes = 0
    asked = "160x120"
    for step in range(600):
        connected.clock.time_s += 0.1
        asked = ("160x120", "640x480")[step % 2]
        before = connected.viewer.streams.status().entry["rendition"]
        connected.viewer.received("state", json.dumps(want_message(asked)))
        changes += before != connected.viewer.streams.status().entry["rendition"]
    assert changes <= 8 + 60
    connected.viewer.received("state", json.dumps(want_message("160x120") | {"picture": False}))
    connected.clock.time_s += 1.1
    connected.viewer.run_deferred(connected.clock.now_s())
    assert connected.video.wanted == []
    assert not connected.viewer.wants_picture


def test_streams_restart_at_a_bounded_rate(monkeypatch: pytest.MonkeyPatch) -> None:
    """A page that swaps two addresses without end gets one restart a second, within its budget."""
    connected = connect()
    calls: list[str] = []
    streams = connected.viewer.streams
    monkeypatch.setattr(streams, "link_changed", lambda: calls.append("anew"))
    monkeypatch.setattr(streams, "keyframe_wanted", lambda _camera: calls.append("keyframe"))
    for _ in range(6000):
        connected.clock.time_s += 0.01
        connected.viewer.network_changed()
        connected.viewer.run_deferred(connected.clock.now_s())
    assert 60 <= calls.count("anew") <= 2 + 60
    assert 30 <= calls.count("keyframe") <= 8 + 30
    calls.clear()
    connected.clock.time_s += 1.1
    connected.viewer.run_deferred(connected.clock.now_s())
    assert calls.count("anew") == 1, "the last one is never lost"
    connected.clock.time_s += 1.1
    connected.viewer.run_deferred(connected.clock.now_s())
    assert calls.count("anew") == 1
