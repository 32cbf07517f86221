"""A viewer whose room and peer record what they get."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, cast

from tests.turned_clock import TurnedClock
from tests.visitors import EVERYTHING, TAB, visitor

from wax.config.audio import AudioSettings
from wax.config.sync import SyncSettings
from wax.config.video import VideoSettings
from wax.fanout.sound_hub import SoundHub
from wax.fanout.video_hub import VideoHub
from wax.session.viewer import Viewer
from wax.streams.live import LiveService
from wax.telemetry import Counters

if TYPE_CHECKING:
    from wax.access.permissions import Role
    from wax.control.controls import Operation
    from wax.control.gate import Command
    from wax.control.reasons import Refusal
    from wax.protocol import messages
    from wax.rtc.peer import Peer


@dataclass
class FakeRoom:
    """The room and the peer of one viewer: records what they do and what they are sent."""

    calls: list[tuple[str, Any]] = field(default_factory=list)
    sent: list[tuple[str, Any]] = field(default_factory=list)
    role: Role = "host"
    refusal: Refusal | None = None
    newest_picture_s: float | None = 100.0

    def viewer_connected(self, viewer: Viewer) -> None:
        self.calls.append(("connected", viewer.number))

    def viewer_changed_network(self, viewer: Viewer) -> None:
        self.calls.append(("moved", viewer.number))

    def viewer_closed(self, viewer: Viewer, peer: Peer) -> None:
        self.calls.append(("closed", peer))

    def viewer_role(self, viewer: Viewer) -> Role:
        return self.role

    def viewer_wants_name(self, viewer: Viewer, name: str) -> None:
        self.calls.append(("name", name))

    def viewer_acts(self, viewer: Viewer, act: messages.HostIn) -> None:
        self.calls.append((act.type, act))

    def viewer_asks(self, viewer: Viewer, request: Any) -> None:
        self.calls.append((request.type, viewer.number))

    def viewer_stops(self, viewer: Viewer, press: int | None) -> None:
        self.calls.append(("stop", press))

    def viewer_releases(self, viewer: Viewer, release: messages.Release) -> None:
        self.calls.append(("release", release.stop))

    def viewer_drives(self, viewer: Viewer, command: Command) -> None:
        self.calls.append(("drive", command))

    def viewer_operates(self, viewer: Viewer, asked: Operation) -> Refusal | None:
        self.calls.append(("operate", asked))
        return self.refusal

    def send(self, channel: str, text: str) -> None:
        self.sent.append((channel, json.loads(text)))

    def media_time(self, kind: str, rtp: int) -> int:  # as a real peer does
        return rtp - 1000

    def set_playout_delay(self, least_ms: float) -> bool:  # its browser cannot
        return False


@dataclass
class Connected:
    viewer: Viewer
    room: FakeRoom
    clock: TurnedClock
    counters: Counters
    video: VideoHub
    audio: SoundHub


SMALLEST = VideoSettings().renditions[-1].name


def connect(sync: SyncSettings | None = None) -> Connected:
    clock, room, counters = TurnedClock(100.0), FakeRoom(), Counters()
    video = VideoHub(settings=VideoSettings(), clock=clock)
    audio = SoundHub(clock)
    viewer = Viewer(
        number=7,
        visitor=visitor("c"),
        grant=EVERYTHING,
        tab=TAB,
        clock=clock,
        counters=counters,
        service=LiveService(
            clock=clock,
            video_settings=VideoSettings(),
            audio_settings=AudioSettings(),
            video=video,
            audio=audio,
        ),
        events=room,
        sync=sync or SyncSettings(),
    )
    viewer.make_lanes()
    viewer.peer = cast("Peer", room)
    viewer.connected()
    viewer.ready()
    return Connected(viewer, room, clock, counters, video, audio)


def drive_row(**changes: object) -> str:
    command = {
        "type": "drive",
        "seq": 1,
        "turn": 2,
        "sent_server_ms": 99_990.0,
        "linear": 0.5,
        "angular": -1.0,
        "held": True,
        "speed": "slow",
        "seen_server_ms": None,
        "axes": {},
        "beat": None,
    }
    return json.dumps(list((command | changes).values()))


def want_message(size: str) -> dict[str, Any]:
    return {"type": "want", "sound": True, "picture": True, "size": size, "policy": None}
