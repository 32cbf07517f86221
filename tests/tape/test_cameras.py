"""Other cameras on the tape: each in its own file, on the part's clock."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

import av
import pytest
from tests.tape.decoded import flashes_s, times_s
from tests.tape.packets import SIZE, pictures
from tests.turned_clock import TurnedClock
from tests.until import until

from wax.capture.testcard import TestCardVideo
from wax.config.recording import RecordingSettings
from wax.config.settings import Settings
from wax.fanout.camera import Camera
from wax.fanout.video_hub import VideoHub
from wax.protocol.tape_events import Filmed, TapeEvent
from wax.tape.camera_files import CameraFormat
from wax.tape.reading import read_events
from wax.tape.recorder import Format, Recorder
from wax.tape.segment import Segment
from wax.tape.shelf import Shelf
from wax.tape.tape import TapeFeed
from wax.telemetry import Counters

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterable
    from pathlib import Path

    from wax.encode.encoded import EncodedPicture
    from wax.tape.shelf import Shelved

BEGIN_S: Final = 1000.0
DOOR, TAIL = CameraFormat("Door", "vp8", SIZE), CameraFormat("Tail", "h264", SIZE)
LENGTH_S: Final = 24.0
PART_S: Final = 10.0


class Rig:
    """A recorder of the driving view and two cameras, in parts of ten seconds."""

    def __init__(self, folder: Path) -> None:
        self.shelf = Shelf(folder)
        self.recorder = Recorder(
            self.shelf,
            settings=RecordingSettings(segment_s=PART_S, min_free_gb=0.0),
            format=Format("vp8", SIZE, False, keyframe_interval_s=1.0, cameras=(DOOR, TAIL)),
            clock=TurnedClock(BEGIN_S),
        )

    def film(self, *cameras: Iterable[EncodedPicture]) -> list[Shelved]:
        """Record the driving view and these cameras; return the parts."""
        film = pictures("vp8", begin_s=BEGIN_S, seconds=LENGTH_S)
        whose = {id(one): number for number, some in enumerate(cameras, 1) for one in some}
        items = [*film, *(one for some in cameras for one in some)]
        for item in sorted(items, key=lambda one: one.captured_s):
            if (number := whose.get(id(item))) is None:
                self.recorder.picture(item)
            else:
                self.recorder.camera(number, item)
        self.recorder.start()
        self.recorder.stop(20.0)
        assert self.recorder.problem is None
        return self.shelf.parts()


@pytest.fixture
def rig(tmp_path: Path) -> Rig:
    return Rig(tmp_path / "tape")


def filmed(part: Shelved) -> dict[int, tuple[str, float]]:
    """Return each camera's name and its start in seconds after the part's."""
    assert part.events is not None
    read = read_events(part.events)
    assert read.problem is None
    return {
        one.event.camera: (one.event.name, one.at_ms / 1000)
        for one in read.events
        if isinstance(one.event, Filmed)
    }


def test_every_camera_is_in_step_with_the_driving_view(rig: Rig) -> None:
    """Cameras stay in step whatever their codec, and with keyframes of their own."""
    door = pictures("vp8", begin_s=BEGIN_S + 0.31, seconds=LENGTH_S - 1)
    tail = pictures("h264", begin_s=BEGIN_S + 0.017, seconds=LENGTH_S - 1)
    parts = rig.film(door, tail)
    assert [set(one.cameras) for one in parts] == [{1, 2}] * 3
    assert [one.cameras[2].suffix for one in parts] == [".mp4"] * 3
    for part in parts:
        assert part.media is not None
        seen = flashes_s(part.media, "video")[2:]
        names = filmed(part)
        assert {camera: name for camera, (name, _) in names.items()} == {1: "Door", 2: "Tail"}
        for camera, path in part.cameras.items():
            began_s = names[camera][1]
            assert 0 <= began_s <= 1.1
            flashes = [began_s + at_s for at_s in flashes_s(path, "video")]
            # A flash appears in the next picture.
            assert all(any(abs(at - one) <= 0.034 for one in flashes) for at in seen[:-1])


def test_a_camera_that_dies_leaves_the_rest_whole(rig: Rig) -> None:
    """A dead camera's file ends, later parts lack it, and it may return in any part."""
    before = pictures("vp8", begin_s=BEGIN_S, seconds=4.0)
    after = pictures("vp8", begin_s=BEGIN_S + 21.5, seconds=2.0)
    parts = rig.film([*before, *after])
    assert [set(one.cameras) for one in parts] == [{1}, set(), {1}]
    for part, length in zip(parts, (10, 10, 4), strict=True):
        assert part.media is not None
        assert len(times_s(part.media, "video")) == pytest.approx(30 * length, abs=1)
    assert times_s(parts[0].cameras[1], "video")[-1] == pytest.approx(4.0, abs=0.05)
    assert filmed(parts[2])[1][1] == pytest.approx(1.5, abs=0.002)
    assert len(times_s(parts[2].cameras[1], "video")) == 60


def segment_of(folder: Path, *cameras: CameraFormat) -> Segment:
    return Segment(
        Shelf(folder),
        origin_s=BEGIN_S,
        zero_ns=10**18,
        codec="vp8",
        size=SIZE,
        has_sound=False,
        cameras=cameras,
    )


def test_a_camera_begins_with_its_keyframe_of_the_part(tmp_path: Path) -> None:
    """A camera's file begins with a keyframe that is no older than the part."""
    segment = segment_of(tmp_path, DOOR)
    film = pictures("vp8", begin_s=BEGIN_S - 0.05, seconds=2.0)
    for picture in film[:30]:
        segment.camera(1, picture)
        assert not segment.has_camera(1)
    for picture in film[30:]:
        segment.camera(1, picture)
        assert segment.has_camera(1)
    segment.close()
    path = Shelf(tmp_path).path(segment.name, ".camera-1.webm")
    assert len(times_s(path, "video")) == 30
    assert times_s(path, "video")[0] == 0.0


def test_a_file_that_fails_at_its_end_leaves_the_others_finished(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """If finishing one file fails, as on a full disk, the others are still finished."""
    segment = segment_of(tmp_path, DOOR, DOOR)
    for picture in pictures("vp8", begin_s=BEGIN_S, seconds=1.0):
        segment.picture(picture)
        segment.camera(1, picture)
        segment.camera(2, picture)

    def fail() -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(segment._cameras._files[2], "close", fail)
    with pytest.raises(OSError, match="No space"):
        segment.close()
    for ending in (".webm", ".camera-1.webm"):
        with av.open(str(Shelf(tmp_path).path(segment.name, ending))) as media:
            assert media.duration is not None  # written last


class TapeRig:
    """A tape of the driving view and a camera without other viewers."""

    def __init__(self, folder: Path, **recording: object) -> None:
        known = {"enabled": True, "folder": str(folder), "min_free_gb": 0.0} | recording
        settings = Settings.model_validate(
            {"recording": known, "camera": [{"name": "Door", "source": "testcard"}]}
        )
        self.clock = TurnedClock()
        self.counters = Counters()
        self.video = VideoHub(settings=settings.video, clock=self.clock)
        one = settings.camera[0]
        source = TestCardVideo(one, self.clock)
        self.camera = Camera(one, source, clock=self.clock, blank=lambda picture: picture)
        self.best = one.renditions[0].name
        self.tape = TapeFeed(
            settings,
            clock=self.clock,
            counters=self.counters,
            video=self.video,
            audio=None,
            cameras=[self.camera],
        )
        self.shelf = Shelf(folder)

    def show(self, picture: EncodedPicture) -> None:
        """Make the camera's hub deliver a picture as if from its best encoder."""
        for lane in self.camera.hub._lanes:
            lane.put(_as(picture, self.best))

    def events(self) -> list[TapeEvent]:
        """Return the events of the only part."""
        (part,) = self.shelf.parts()
        assert part.events is not None
        return [one.event for one in read_events(part.events).events]


def _as(picture: EncodedPicture, rendition: str) -> EncodedPicture:
    return replace(picture, rendition=rendition)


@pytest.fixture
async def tape_rig(tmp_path: Path) -> AsyncIterator[TapeRig]:
    made = TapeRig(tmp_path / "tape")
    made.tape.start()
    yield made
    made.tape.stop()


async def test_it_wants_the_best_of_each_camera(tape_rig: TapeRig) -> None:
    """The best rendition is encoded for the tape though nobody watches."""
    assert tape_rig.camera.hub.wanted == [tape_rig.best]
    assert tape_rig.tape.has_cameras


async def test_a_camera_is_asked_for_the_keyframe_with_which_it_begins(
    tape_rig: TapeRig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One keyframe is requested for each part, since its viewers pay for it."""
    asked: list[float] = []
    rendition = tape_rig.camera.hub._renditions[tape_rig.best]
    monkeypatch.setattr(
        rendition, "request_keyframe", lambda **_: asked.append(tape_rig.clock.time_s)
    )
    recorder = tape_rig.tape.recorder
    film = pictures("vp8", begin_s=BEGIN_S, seconds=2.0)
    tape_rig.show(film[0])
    assert asked == []  # no part has begun
    recorder.picture(film[0])
    until(lambda: recorder.needs_keyframe(1))
    for picture in film[1:4]:
        tape_rig.show(picture)
    assert asked == [1000.0]
    tape_rig.clock.time_s += 1.5
    tape_rig.show(film[4])
    assert asked == [1000.0, 1001.5]  # it did not arrive
    tape_rig.clock.time_s += 1.5
    tape_rig.show(film[30])
    until(lambda: not recorder.needs_keyframe(1))
    asked.clear()
    tape_rig.show(film[31])
    assert asked == []
    tape_rig.tape.stop()
    assert tape_rig.events() == [Filmed(camera=1, name="Door")]


async def test_an_error_in_a_cameras_track_ends_it_and_nothing_else(
    tape_rig: TapeRig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After an error in its track a camera is not encoded, and the driving view still recorded."""

    def fail(*_: object) -> None:
        raise RuntimeError

    monkeypatch.setattr(tape_rig.tape.recorder, "camera", fail)
    (lane,) = tape_rig.camera.hub._lanes
    put = tape_rig.camera.hub._lanes[lane]
    put(_as(pictures("vp8", begin_s=BEGIN_S, seconds=0.1)[0], tape_rig.best))
    assert tape_rig.camera.hub.wanted == []
    assert tape_rig.video.wanted != []
    assert tape_rig.tape.recorder.problem is None
    assert tape_rig.counters.snapshot() == {"viewer faults": 1}


async def test_cameras_are_left_out_where_they_are_not_to_be_recorded(tmp_path: Path) -> None:
    """Without recorded cameras, the tape encodes only the driving view."""
    rig = TapeRig(tmp_path / "tape", cameras=False)
    rig.tape.start()
    assert rig.camera.hub.wanted == []
    assert rig.video.wanted != []
    assert not rig.tape.has_cameras
    rig.tape.stop()
