"""A room with everything real but peers, robot, rooms and time."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Literal, cast, get_args

from tests.control.rules import VOUCHED
from tests.heard_events import Heard
from tests.idle_robot import IdleRobot
from tests.rtc.networks import network
from tests.turned_clock import TurnedClock
from tests.visitors import TAB, make_access, visitor

from wax.access.access import Shown
from wax.access.host_decisions import HostDecisions
from wax.capture.audio_blocks import Blocks
from wax.capture.channel_faults import ChannelFaults
from wax.cluster.cluster import Cluster, RoomSeat
from wax.cluster.room_directory import Occupancy, choose
from wax.config.settings import Settings
from wax.control.driving_view import DrivingView
from wax.control.loop import ControlLoop
from wax.control.turns import Turns
from wax.driver.interface import Aboard, ControlValue, Limits, RobotState, Twist
from wax.fanout.sound_hub import SoundHub
from wax.fanout.video_hub import VideoHub
from wax.protocol import room_change
from wax.protocol.host_switches import HostSwitches
from wax.records.records import Records
from wax.session import entry as entry_module
from wax.session.headroom import Headroom, Used
from wax.session.kept_state import KeptFile
from wax.session.parts import Parts
from wax.session.record_keeper import RecordKeeper
from wax.session.room import Room
from wax.session.viewers import Viewers
from wax.streams.live import LiveService
from wax.telemetry import Counters

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    import pytest

    from wax.door.tunnel import Tunnel
    from wax.hooks.hooks import Hooks
    from wax.house.house import House
    from wax.pipelines import Pipelines
    from wax.protocol.host_switches import HostSwitch
    from wax.rtc.peer import Peer, PeerEvents
    from wax.sentence import Sentence


OFFER = "\n".join(
    [
        "v=0",
        "m=audio 9 x 111",
        "a=rtpmap:111 opus/48000/2",
        "m=video 9 x 96",
        "a=rtpmap:96 VP8/90000",
        "m=application 9 x 0",
    ]
)


class Robot(IdleRobot):
    """A driver that records what it is told."""

    kind = "noted"
    limits = Limits(1.0, 2.0, ("pan",), controls=("lamp", "horn"))

    def __init__(self) -> None:
        self.told: list[object] = []
        self.problem: str | None = None
        self.is_broken = False
        self.aboard: Aboard | None = None
        self.gauges: dict[str, float] = {}
        self.ttl_s: float | None = None

    def apply(self, twist: Twist, turn: int) -> None:
        self.told.append(twist)

    def control(self, name: str, value: ControlValue, turn: int) -> None:
        self.told.append((name, value))

    def stop(self, turn: int) -> None:
        self.told.append("stop")

    def state(self) -> RobotState:
        if self.is_broken:
            raise OSError("no bus")
        return RobotState(
            connected=self.problem is None,
            problem=self.problem,
            aboard=self.aboard,
            gauges=self.gauges,
            ttl_s=self.ttl_s,
        )


class Camera:
    """A capture that fails and recovers when told."""

    problem: Sentence | None = None
    failures = 0


class FakePeer:
    """Stands in for a peer: opens at once, and records what is sent."""

    made: list[FakePeer]

    def __init__(self, *, events: PeerEvents, **_: Any) -> None:
        self.events = events
        self.sent: list[dict[str, Any]] = []
        self.rows: list[list[Any]] = []
        self.room: dict[str, Any] = {}
        self.beat: str | None = None
        self.newest_picture_s = math.inf
        self.is_alive = True
        self.accepted = ""
        FakePeer.made.append(self)

    async def answer(self, offer: str) -> str:
        return f"answer to {offer}"

    async def offer(self) -> str:
        return "our offer"

    async def accept(self, answer: str) -> None:
        self.accepted = answer

    def send(self, channel: Literal["drive", "state"], text: str) -> None:
        message = json.loads(text)
        if channel == "drive":
            self.rows.append(message)
            self.beat = message[-1] if message[0] in ("pong", "beat") else self.beat
            return
        if message["type"] == "room_change":
            message = room_change.applied(self.room, message)
        if message["type"] == "room":
            self.room = message
        self.sent.append(message)

    def set_playout_delay(self, least_ms: float) -> bool:  # its browser cannot
        return False

    def abandon(self) -> None:
        if self.is_alive:
            self.is_alive = False
            self.events.closed(cast("Peer", self))

    async def close(self) -> None:
        self.abandon()

    def open(self) -> None:
        self.events.connected()
        self.events.ready()

    def pings(self) -> None:
        """Send a ping, and get the beat in its pong."""
        self.events.received("drive", '["ping",1,0,null,null]')

    def says(self, **message: object) -> None:
        self.events.received("state", json.dumps(message))

    def last(self, kind: str) -> dict[str, Any]:
        return next(m for m in reversed(self.sent) if m["type"] == kind)


def fake_peers(monkeypatch: pytest.MonkeyPatch, kind: type[FakePeer] = FakePeer) -> None:
    """Have rooms make peers of this kind."""
    FakePeer.made = []
    monkeypatch.setattr(entry_module, "Peer", kind)


class FakeCluster:
    """A cluster of two rooms, without the network."""

    def __init__(self, most: int = 2) -> None:
        self.rooms = [Occupancy(name, most) for name in ("a", "b")]
        self.removed: list[tuple[str, bool]] = []
        self.has_sound = True
        self.links: list[str] = []
        self.is_used = True
        self.watching = 3
        self.news: Callable[[], str | None] = lambda: None

    @property
    def capacity(self) -> int:
        return sum(one.most for one in self.rooms)

    def seats(self, person: str, before: Sequence[str] = ()) -> list[RoomSeat]:
        return [
            RoomSeat(one.name, f"wss://{one.name}", person) for one in choose(self.rooms, before)
        ]

    def broadcast(self, news: Callable[[], str | None]) -> None:
        self.news = news

    def remove(self, person: str, *, for_good: bool = False) -> None:
        self.removed.append((person, for_good))


def switching(switch: HostSwitch) -> dict[str, Any]:
    """Return the host's message that gives a switch another value than it has at first."""
    [kind] = get_args(switch.act.model_fields["type"].annotation)
    is_off = getattr(HostSwitches(), switch.kept) is False
    return {"type": kind, switch.field: True if is_off else 0.25}


class Rig:
    """A server with everything real but peers, robot and time."""

    def __init__(self, tree: dict[str, Any], cluster: FakeCluster | None = None) -> None:
        settings = Settings.model_validate(tree)
        self.clock = TurnedClock()
        self.robot = Robot()
        turns = self.turns = Turns(settings.turns)
        self.camera = Camera()
        self.counters = Counters()
        video = VideoHub(settings=settings.video, clock=self.clock)
        audio = SoundHub(self.clock)
        self.view = DrivingView()
        self.view.clock = VOUCHED
        idle = SimpleNamespace(problems=list, status=lambda: None)
        self.tunnel = SimpleNamespace(problem=None, problems=list, status=lambda: None)
        self.decisions = HostDecisions()
        self.records = Records(self.clock)
        self.access = make_access(
            self.records, self.clock, settings.access, decisions=self.decisions
        )
        self.viewers = Viewers(
            sync=settings.sync, turns=turns, has_camera=True, decisions=self.decisions
        )
        self.heard = Heard(self.clock)
        self.keeper = RecordKeeper(
            records=self.records,
            clock=self.clock,
            viewers=self.viewers,
            refused=self.counters.snapshot,
            event_maker=self.heard.event_maker,
        )
        self.loop = ControlLoop(
            clock=self.clock,
            settings=settings,
            driver=self.robot,
            turns=turns,
            operators=self.viewers,
            view=self.view,
        )
        self.headroom = Headroom(1.0, self.clock, lambda: 0.0)
        self.loop.listen(self.viewers)
        self.kept = KeptFile(settings.server.state_dir)
        self.parts = Parts(
            settings=settings,
            clock=self.clock,
            counters=self.counters,
            driver=self.robot,
            pipelines=cast(
                "Pipelines",
                SimpleNamespace(
                    service=LiveService(
                        clock=self.clock,
                        video_settings=settings.video,
                        audio_settings=settings.audio,
                        video=video,
                        audio=audio,
                        upload_bps=settings.network.upload_bps,
                    ),
                    video=video,
                    audio=audio,
                    captures={"video": self.camera},
                    cameras=[],
                    encoders=[],
                    view=self.view,
                    blocks=Blocks(),
                    channel_faults=ChannelFaults(lambda _: None, most=2),
                ),
            ),
            network=network(),
            cluster=cast("Cluster", cluster or Cluster(clock=self.clock, counters=self.counters)),
            turns=turns,
            viewers=self.viewers,
            control=self.loop,
            access=self.access,
            decisions=self.decisions,
            kept=self.kept,
            records=self.records,
            keeper=self.keeper,
            headroom=self.headroom,
            tunnel=cast("Tunnel", self.tunnel),
            hooks=cast("Hooks", idle),
            house=cast("House", idle),
        )
        self.room = Room(self.parts)

    async def enter(self, client: str, *, is_host: bool = False) -> FakePeer:
        sign_in = self.sign_in() if is_host else ""
        await self.room.answer(replace(visitor(client), sign_in=sign_in), TAB, OFFER)
        FakePeer.made[-1].open()
        FakePeer.made[-1].pings()
        return FakePeer.made[-1]

    def sign_in(self) -> str:
        """Sign in as the host, by a link of its own."""
        cookie = self.access.become_host(self.access.new_host_link())
        return self.access.visitor(Shown(host=cookie), "192.0.2.1").sign_in

    def wait(self, seconds: float, *alive: FakePeer) -> None:
        """Let time pass in steps; the pages in `alive` send pings."""
        for _ in range(round(seconds * 10)):
            self.clock.time_s += 0.1
            for peer in alive:
                peer.pings()
            self.loop.step(self.clock.time_s)
            self.round()

    def round(self) -> None:
        """Let the room run a whole round at once."""
        for _ in self.room.round(self.clock.time_s):
            pass

    def drive(self, peer: FakePeer, seq: int, *, linear: float) -> None:
        """Let a page send a set-point at this moment, in the turn that runs."""
        turn = self.room.snapshot(self.clock.time_s).turn.number
        now_ms = self.clock.time_s * 1000
        hands = [linear, 0.0, linear != 0, "fast"]
        row = ["drive", seq, turn, now_ms, *hands, now_ms, {}, peer.beat]
        peer.events.received("drive", json.dumps(row))

    def keep_busy(self, share: float) -> None:
        """Have used this share of the machine's only core for the last ten seconds."""
        for number in range(11):
            self.headroom.sample(Used(number * share, number * share, 0.0))
            self.clock.time_s += 1.0

    def names(self) -> list[str]:
        return [line.name for line in self.room.snapshot(self.clock.time_s).viewers]
