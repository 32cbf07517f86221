"""Who speaks through the robot: decided on the server, for each packet, in a real room."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

from wax.protocol.messages import VoiceInfo
from wax.sentence import Sentence
from wax.session.voices import Voices
from wax.voice.packet import VoicePacket

if TYPE_CHECKING:
    from tests.session.rig import FakePeer, Rig

    from wax.session.viewer import Viewer

GONE = Sentence("speaker.gone", {"speaker": Sentence("speaker.default")})


class Played:
    """An output that records what it is given to play."""

    def __init__(self) -> None:
        self.problem: Sentence | None = None
        self.sounded_s = float("-inf")
        self.packets: list[VoicePacket] = []
        self.hushed = 0
        self.is_silent = False

    def push(self, packet: VoicePacket, now_s: float) -> None:
        self.packets.append(packet)
        if not self.is_silent:
            self.sounded_s = now_s

    def hush(self) -> None:
        self.hushed += 1


class Scene:
    """A room where people speak."""

    def __init__(self, rig: Rig) -> None:
        self.rig = rig
        self.output = Played()
        self.voices = Voices(
            speaker=self.output,
            clock=rig.clock,
            counters=rig.counters,
            decisions=rig.decisions,
            viewers=rig.viewers,
            turns=rig.turns,
            control=rig.loop,
        )

    def viewer(self, number: int) -> Viewer:
        viewer = self.rig.viewers.numbered(number)
        assert viewer is not None
        return viewer

    def speak(self, number: int, seconds: float = 0.2) -> int:
        """Have somebody speak; return how many of their packets are played."""
        before = len(self.output.packets)
        for step in range(round(seconds * 50)):
            self.rig.clock.time_s += 0.02
            packet = VoicePacket(7, step * 960, 960, b"x")
            self.voices.receive(self.viewer(number), packet)
            self.voices.send_changes(self.rig.clock.time_s)
        return len(self.output.packets) - before

    def wait(self, seconds: float) -> None:
        for _ in range(round(seconds * 20)):
            self.rig.clock.time_s += 0.05
            self.voices.send_changes(self.rig.clock.time_s)


@pytest.fixture
async def host(rig: Rig) -> FakePeer:
    return await rig.enter("hedy-111", is_host=True)


@pytest.fixture
async def bob(rig: Rig, host: FakePeer) -> FakePeer:
    return await rig.enter("bob-1111")


@pytest.fixture
async def scene(rig: Rig, host: FakePeer, bob: FakePeer) -> Scene:
    return Scene(rig)


def told(peer: FakePeer) -> list[tuple[bool, Any]]:
    return [(one["heard"], one["reason"]) for one in peer.sent if one["type"] == "heard"]


def drives(scene: Scene, bob: FakePeer, host: FakePeer) -> None:
    bob.says(type="join")
    scene.rig.wait(0.3, bob, host)
    assert scene.rig.room.snapshot(scene.rig.clock.time_s).turn.operator == 2


async def test_the_operator_is_heard_and_informed(
    scene: Scene, bob: FakePeer, host: FakePeer
) -> None:
    """Everybody sees who speaks, until a moment after the last word."""
    drives(scene, bob, host)
    assert scene.speak(2) == 10
    assert told(bob) == [(True, None)]
    assert scene.voices.info() == VoiceInfo(speaker=2)
    scene.wait(1)
    assert told(bob) == [(True, None), (False, None)]
    assert scene.voices.info().speaker is None
    assert told(host) == []


async def test_an_observer_is_never_heard(scene: Scene, bob: FakePeer) -> None:
    """An observer reads one sentence, however long they go on, and nothing is played."""
    assert scene.speak(2, 3) == 0
    [(heard, reason)] = told(bob)
    assert not heard
    assert reason == {"code": "voice.not_yours"}
    assert scene.rig.counters.snapshot()["voice packets not allowed"] == 150


async def test_the_host_may_speak_without_driving(scene: Scene, host: FakePeer) -> None:
    """They are beside their robot in spirit."""
    assert scene.speak(1) == 10
    assert told(host) == [(True, None)]


async def test_the_end_of_a_turn_mutes_at_once(scene: Scene, bob: FakePeer, host: FakePeer) -> None:
    """Queued sound is dropped with the turn, and the next packet is refused."""
    drives(scene, bob, host)
    scene.speak(2)
    host.says(type="end_turn", turn=1)
    scene.rig.wait(0.1, bob, host)
    scene.voices.check()
    assert scene.output.hushed == 1
    assert scene.speak(2) == 0


async def test_the_end_of_a_turn_needs_no_call(scene: Scene, bob: FakePeer, host: FakePeer) -> None:
    """Without the call, the next packet silences them, too."""
    drives(scene, bob, host)
    scene.speak(2)
    host.says(type="end_turn", turn=1)
    scene.rig.wait(0.1, bob, host)
    scene.voices.receive(scene.viewer(2), VoicePacket(7, 0, 960, b"x"))
    assert scene.output.hushed == 1


@pytest.mark.parametrize("act", ["mute_voices", "blank"])
async def test_the_host_mutes_everybody(
    scene: Scene, bob: FakePeer, host: FakePeer, act: str
) -> None:
    """Everybody is silent within 300 ms, the host too, until the host unmutes them."""
    drives(scene, bob, host)
    scene.speak(2)
    key = "muted" if act == "mute_voices" else "blanked"
    host.says(type=act, **{key: True})
    scene.wait(0.1)
    assert scene.output.hushed == 1
    assert scene.speak(2, 0.5) == 0
    assert scene.speak(1, 0.5) == 0
    assert told(bob)[-1] == (False, {"code": "voice.muted"})
    assert scene.voices.info().muted is (act == "mute_voices")
    host.says(type=act, **{key: False})
    assert scene.speak(2) == 10


async def test_a_second_speaker_waits_for_the_first(
    scene: Scene, bob: FakePeer, host: FakePeer
) -> None:
    """The second reads who is speaking, and is heard once the first has finished."""
    drives(scene, bob, host)
    for _ in range(30):
        assert scene.speak(2, 0.02) == 1
        assert scene.speak(1, 0.02) == 0
    [(heard, reason)] = told(host)
    assert not heard
    assert reason == {"code": "voice.taken", "values": {"name": "Guest 2"}}
    scene.wait(0.6)
    assert scene.speak(1) == 10


async def test_silence_does_not_keep_others_from_speaking(
    scene: Scene, bob: FakePeer, host: FakePeer
) -> None:
    """A viewer who leaves the microphone open but says nothing is not "heard"."""
    drives(scene, bob, host)
    scene.output.is_silent = True
    scene.speak(2, 1)
    assert told(bob) == [(False, None)]
    assert scene.speak(1, 0.1) == 5


async def test_a_speaker_that_does_not_play_is_reported(
    scene: Scene, bob: FakePeer, host: FakePeer
) -> None:
    """The speaking viewer reads why, without details, and everybody in the room's state."""
    drives(scene, bob, host)
    scene.output.problem = GONE
    assert scene.speak(2) == 0
    assert told(bob) == [(False, {"code": "speaker.silent"})]
    assert scene.voices.info().problem == GONE


async def test_a_flood_is_bounded(scene: Scene, host: FakePeer) -> None:
    """More packets than a voice needs are counted and dropped, before any decision."""
    for number in range(1000):
        scene.voices.receive(scene.viewer(1), VoicePacket(7, number * 960, 960, b"x"))
        scene.voices.receive(scene.viewer(1), None)
    assert len(scene.output.packets) == 60
    counters = scene.rig.counters.snapshot()
    assert counters["voice packets over the rate"] == 940
    assert counters["voice packets refused"] == 1000


async def test_nobody_takes_the_stream_of_another(
    scene: Scene, bob: FakePeer, host: FakePeer
) -> None:
    """Two pages with the same SSRC are two voices."""
    drives(scene, bob, host)
    scene.speak(2)
    scene.wait(1)
    scene.speak(1)
    assert len({packet.source for packet in scene.output.packets}) == 2


async def test_an_output_that_raises_ends_one_peer(
    scene: Scene, bob: FakePeer, host: FakePeer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An error in one viewer's voice is theirs alone."""

    def broken(*_: Any) -> None:
        raise RuntimeError("broken")

    drives(scene, bob, host)
    monkeypatch.setattr(scene.output, "push", broken)
    scene.speak(2, 0.02)
    assert not bob.is_alive
    assert host.is_alive
