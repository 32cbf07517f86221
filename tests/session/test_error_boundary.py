"""One viewer's fault: it ends that viewer's peer, and all others go on."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, NoReturn, cast

import numpy as np
import pytest
from structlog.testing import capture_logs
from tests.session.rig import FakePeer, Rig, fake_peers
from tests.turned_clock import TurnedClock
from tests.visitors import EVERYTHING, TAB, visitor

from wax.baseline.streams import BaselineService, thesis_video
from wax.baseline.unit_hub import UnitHub
from wax.capture.source import BLOCK_SAMPLES, Sound
from wax.config.thesis import ThesisSettings
from wax.config.video import VideoSettings
from wax.congestion.allocation import SoundEncoding
from wax.encode.encoded import EncodedPicture
from wax.error_boundary import ErrorBoundary
from wax.fanout.sound_hub import SoundHub
from wax.fanout.video_hub import VideoHub
from wax.session.status import Status
from wax.session.viewer import Viewer
from wax.streams.interface import MessageRate
from wax.telemetry import Counters

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.rtc.peer import Peer


def fail(*_: object, **__: object) -> NoReturn:
    raise ValueError("a viewer's fault")


class Ended:
    """A boundary, and how often the peer behind it was ended."""

    def __init__(self) -> None:
        self.count = 0
        self.counters = Counters()
        self.boundary = ErrorBoundary(viewer=7, counters=self.counters, end=self._end)

    def _end(self) -> None:
        self.count += 1


# --- the boundary itself ----------------------------------------------------------------------


def test_a_fault_stays_inside_is_logged_once_and_ends_the_peer() -> None:
    """Each fault is counted and ends the peer, and only the first is logged."""
    ended = Ended()
    with capture_logs() as logs:
        for _ in range(3):
            ended.boundary.around(fail)(1, two=2)
    assert ended.count == 3
    assert ended.counters.snapshot() == {"viewer faults": 3}
    assert [(line["log_level"], line["viewer"]) for line in logs] == [("error", 7)]


def test_successful_calls_pass_through() -> None:
    """Arguments arrive, and nothing is counted or ended."""
    ended = Ended()
    got: list[tuple[object, ...]] = []
    ended.boundary.around(lambda *args, **kwargs: got.append((args, kwargs)))(1, two=2)
    assert got == [((1,), {"two": 2})]
    assert ended.count == 0
    assert ended.counters.snapshot() == {}


@pytest.mark.parametrize("error", [KeyboardInterrupt, asyncio.CancelledError])
def test_the_end_of_the_server_is_no_viewers_fault(error: type[BaseException]) -> None:
    """An exception that ends a task or the process passes through."""
    ended = Ended()
    with pytest.raises(error), ended.boundary:
        raise error
    assert ended.count == 0


def test_a_peer_that_cannot_be_ended_harms_nobody() -> None:
    """An error raised while ending the peer stays inside, too."""
    with ErrorBoundary(viewer=7, counters=Counters(), end=fail):
        fail()


# --- the room ------------------------------------------------------------------------------


class Later(FakePeer):
    """Closes a moment after it was told to, as a peer does."""

    def abandon(self) -> None:
        asyncio.get_running_loop().call_soon(super().abandon)

    async def close(self) -> None:
        super().abandon()


@pytest.fixture
def rig(monkeypatch: pytest.MonkeyPatch) -> Rig:
    fake_peers(monkeypatch, Later)
    return Rig({"turns": {"turn_s": 5.0}, "sync": {"operator": {"policy": "video-first"}}})


def _broken(**parts: Callable[..., object]) -> Any:
    return type("Broken", (), {name: property(part) for name, part in parts.items()})()


def _break_send(viewer: Viewer, patch: pytest.MonkeyPatch) -> None:
    patch.setattr(viewer.peer, "send", fail)


class Unknown(Later):
    """Raises when `is_alive` is read for the first time."""

    def __getattribute__(self, name: str) -> Any:
        if name == "is_alive":
            self.__class__ = Later  # type: ignore[assignment]  # otherwise the same peer
            fail()
        return super().__getattribute__(name)


def _break_liveness(viewer: Viewer, patch: pytest.MonkeyPatch) -> None:
    patch.setattr(viewer.peer, "__class__", Unknown)


def _break_drive_status(viewer: Viewer, patch: pytest.MonkeyPatch) -> None:
    patch.setattr(viewer, "send_drive_status", fail)


def _break_name(viewer: Viewer, patch: pytest.MonkeyPatch) -> None:
    patch.setattr(viewer, "name", 7)  # no text: the room's message cannot be made with it


def _break_follow(viewer: Viewer, patch: pytest.MonkeyPatch) -> None:
    patch.setattr(viewer.streams, "set_role", fail)


def _break_link(viewer: Viewer, patch: pytest.MonkeyPatch) -> None:
    link = viewer.link
    broken = _broken(one_way_s=fail, newest_s=lambda _: None)
    broken.record_arrival, broken.silence_s = link.record_arrival, link.silence_s
    patch.setattr(viewer, "link", broken)


BREAKS = {
    "a message to all": _break_send,
    "whether the peer is alive": _break_liveness,
    "what becomes of the commands": _break_drive_status,
    "a line of the room": _break_name,
    "the policy of the role": _break_follow,
    "the delay of the link": _break_link,
}


@pytest.mark.parametrize("breaks", BREAKS.values(), ids=BREAKS.keys())
async def test_a_fault_in_one_viewer_ends_only_that_peer(
    rig: Rig,
    breaks: Callable[[Viewer, pytest.MonkeyPatch], None],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Rounds, messages and turns of all others go on, whatever one viewer's part raises."""
    eve, ada, bob = [await rig.enter(f"{who}-1111") for who in ("eve", "ada", "bob")]
    rig.wait(0.2, eve, ada, bob)
    breaks(next(iter(rig.viewers)), monkeypatch)
    ada.sent.clear()
    bob.sent.clear()
    eve.says(type="join")  # eve drives, so that the loop asks for eve's link; ada is next
    ada.says(type="join")
    rig.wait(0.3, eve, ada, bob)
    await asyncio.sleep(0)
    rig.wait(0.3, ada, bob)
    assert [peer.is_alive for peer in (eve, ada, bob)] == [False, True, True]
    assert rig.counters.snapshot()["viewer faults"] >= 1
    for peer in (ada, bob):
        lines = {line["id"]: line for line in peer.last("room")["viewers"]}
        assert lines[2]["place"] is not None
    rig.wait(9.0, ada, bob)
    assert bob.last("room")["turn"]["operator"] == 2
    assert ada.last("playout")["policy"] == "video-first"
    assert "drive_status" in [message["type"] for message in ada.sent]


async def test_a_peer_that_cannot_be_abandoned_stops_no_round(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The sweep closes the other dead peers, and the other pages are informed."""
    eve, bob, ada = [await rig.enter(f"{who}-1111") for who in ("eve", "bob", "ada")]
    monkeypatch.setattr(eve, "abandon", fail)
    rig.wait(10.3, ada)
    await asyncio.sleep(0)
    assert not bob.is_alive
    ada.says(type="name", name="Ada")
    rig.wait(0.1, ada)
    assert "Ada" in [line["name"] for line in ada.last("room")["viewers"]]


async def test_the_robot_stops_even_if_its_operators_streams_cannot_be_released(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The operator is lost at once, even if ending the streams raises."""
    eve = await rig.enter("eve-1111")
    eve.says(type="join")
    rig.wait(0.3, eve)
    rig.robot.told.clear()
    with monkeypatch.context() as patch:
        patch.setattr(next(iter(rig.viewers)).streams, "release", fail)
        await eve.close()
    assert "stop" in rig.robot.told
    assert rig.room.snapshot(rig.clock.time_s).viewers[0].lost


async def test_one_peer_that_does_not_close_keeps_no_other_open(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At the end of the server every peer is closed, whatever one of them raises."""
    eve, ada = await rig.enter("eve-1111"), await rig.enter("ada-1111")
    monkeypatch.setattr(eve, "close", fail)
    await rig.room.close()
    assert not ada.is_alive


async def test_the_status_still_has_all_others(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    """A viewer whose streams raise is listed with name and place only."""
    await rig.enter("eve-1111")
    await rig.enter("ada-1111")
    monkeypatch.setattr(next(iter(rig.viewers)).streams, "status", fail)
    status = Status(rig.parts, rig.room, dict)
    broken, whole = cast("list[dict[str, Any]]", status()["viewers"])
    assert broken["id"] == 1
    assert "streams" not in broken
    assert whole["streams"]["policy"] == "audio-master"


# --- what serves everybody -----------------------------------------------------------------


def _picture(captured_s: float, rendition: str) -> EncodedPicture:
    pts = round(captured_s * 90_000)
    return EncodedPicture(b"picture", pts, rendition, keyframe=True, layer=0, captured_s=captured_s)


def test_a_lane_that_cannot_take_a_picture_keeps_none_from_others() -> None:
    """The fan-out serves the lanes after the one that raises, and the peer behind that one ends."""
    hub = VideoHub(settings=VideoSettings(), clock=TurnedClock())
    first, second = Ended(), Ended()
    broken, whole = hub.add(first.boundary), hub.add(second.boundary)
    broken.set_listener(fail)
    for lane in (broken, whole):
        hub.choose(lane, hub.names[0])
    hub._fan_out(_picture(1.0, hub.names[0]))
    assert whole.pop_next() is not None
    assert (first.count, second.count) == (1, 0)


async def test_a_lane_that_cannot_take_sound_keeps_none_from_others(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The same holds for sound."""
    hub, encoding = SoundHub(TurnedClock(0.0)), SoundEncoding(20, 32_000)
    hub.start()
    first, second = Ended(), Ended()
    broken, whole = hub.add(first.boundary), hub.add(second.boundary)
    for lane in (broken, whole):
        hub.choose(lane, encoding, 0)
    monkeypatch.setattr(broken, "_queue", None)
    for number in range(6):
        hub.push(Sound(np.zeros(BLOCK_SAMPLES, np.int16), 1.0 + number / 100))
    await asyncio.sleep(0)
    assert whole.pop_next() is not None
    assert first.count > 0
    assert second.count == 0


class ThesisPage:
    """A page of the baseline, whose messages begin to fail at some moment."""

    def __init__(self, ended: Ended) -> None:
        self.boundary = ended.boundary
        self.send: Callable[[object], None] = lambda _message: None

    def set_playout_delay(self, least_ms: float) -> bool:
        return False


@pytest.mark.parametrize("what", ["sound", "picture", "timer"])
async def test_a_page_of_the_baseline_that_fails_keeps_nothing_from_others(
    what: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Units of sound, pictures and the sender's timer reach everybody else's streams."""
    clock, settings = TurnedClock(10.0), ThesisSettings()
    video = VideoHub(settings=thesis_video(VideoSettings(), settings), clock=clock)
    audio = UnitHub(mu_ms=settings.audio_mu_ms)
    audio.start()
    service = BaselineService(clock=clock, settings=settings, video=video, audio=audio)
    ended = [Ended(), Ended()]
    streams = [service.streams(ThesisPage(one), cast("Any", None)) for one in ended]
    for one in streams:
        one.make_lanes()
        one.want(sound=what != "picture", picture=what != "sound", size="", policy=None)
    monkeypatch.setattr(streams[0], "_apply" if what != "timer" else "_sender", fail)
    got: list[object] = []
    monkeypatch.setattr(streams[1], "_apply", got.append)
    if what == "sound":
        for number in range(60):
            audio.push(Sound(np.zeros(BLOCK_SAMPLES, np.int16), 10.0 + number / 100))
        await asyncio.sleep(0)
    elif what == "picture":
        video._fan_out(_picture(10.0, video.names[0]))
    else:
        for one in streams:
            assert one._timer is not None
            one._timer._run()
    assert got
    assert (ended[0].count, ended[1].count) == (1, 0)
    monkeypatch.undo()
    for one in streams:
        one.release()


def test_the_peer_of_another_connection_has_another_boundary() -> None:
    """After a reconnection the first fault is logged again."""
    made: list[ErrorBoundary] = []
    streams = SimpleNamespace(make_lanes=lambda: None, release=lambda: None)
    service = cast(
        "Any", SimpleNamespace(state_messages=MessageRate(1.0, 1), streams=lambda *_: streams)
    )
    viewer = Viewer(
        number=1,
        visitor=visitor("c"),
        grant=EVERYTHING,
        tab=TAB,
        clock=TurnedClock(),
        counters=Counters(),
        service=service,
        events=cast("Any", None),
        sync=cast("Any", None),
    )
    for _ in range(2):
        viewer.make_lanes()
        made.append(viewer.boundary)
    assert len({id(boundary) for boundary in made}) == 2
    viewer.peer = cast("Peer", SimpleNamespace(send=fail, abandon=made.clear))
    with capture_logs() as logs:
        viewer.send_text("{}")
    assert (len(logs), made) == (1, [])
