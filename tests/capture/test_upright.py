"""The picture of a camera that is mounted at an angle is shown upright."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from tests.capture.card_reader import read_stamp
from tests.idle_robot import IdleRobot

from wax.capture.find_sources import make_camera, make_sources
from wax.capture.letterbox import planes
from wax.capture.source import Picture
from wax.capture.testcard import TestCardVideo
from wax.capture.upright import Upright, turned
from wax.clock import Clock, SystemClock
from wax.config.audio import AudioSettings
from wax.config.camera import CameraSettings
from wax.config.video import DrivingViewSettings, VideoSettings

RANDOM = np.random.default_rng(7).integers(0, 255, (48 * 3 // 2, 64), dtype=np.uint8)


@pytest.mark.parametrize("mirror", [False, True])
@pytest.mark.parametrize("quarters", range(4))
def test_each_plane_is_turned_and_then_mirrored(quarters: int, mirror: bool) -> None:
    """Luma and chroma turn clockwise, and then the upright picture is mirrored."""
    found = turned(RANDOM, quarters, mirror=mirror)
    for before, after in zip(planes(RANDOM), planes(found), strict=True):
        upright = np.rot90(before, -quarters)
        assert (after == (upright[:, ::-1] if mirror else upright)).all()


class SidewaysRobot(IdleRobot):
    """A driver whose cameras deliver a picture of odd proportions at a fixed time."""

    def camera(self, settings: VideoSettings, clock: Clock) -> SidewaysRobot:
        return self

    external_view = camera

    def read(self) -> Picture:
        return Picture(RANDOM, 77.0, within_s=0.02)


@pytest.mark.parametrize(
    ("rotate", "mirror", "size"),
    [(0, False, (64, 48)), (90, False, (48, 64)), (180, True, (64, 48)), (270, True, (48, 64))],
)
def test_every_camera_is_turned_as_its_table_says(
    rotate: int, mirror: bool, size: tuple[int, int]
) -> None:
    """Driving view and other cameras turn by their own settings, and keep their times."""
    keys = {"source": "robot", "rotate": rotate, "mirror": mirror}
    robot, clock = SidewaysRobot(), SystemClock()
    view = DrivingViewSettings.model_validate(keys)
    beside = CameraSettings.model_validate(keys | {"name": "Arm"})
    for source in (
        make_sources(view, AudioSettings(source="none"), clock, robot).video,
        make_camera(beside, clock, robot),
    ):
        assert source is not None
        picture = source.read()
        assert (picture.width, picture.height) == size
        assert (picture.captured_s, picture.within_s) == (77.0, 0.02)
        assert (picture.i420 == turned(RANDOM, rotate // 90, mirror=mirror)).all()


def test_a_ladder_lies_or_stands_with_its_camera() -> None:
    """A quarter turn turns the default ladder, but not one that is configured."""
    for model, name in (
        (DrivingViewSettings, {}),
        (CameraSettings, {"name": "Arm", "source": "1"}),
    ):
        lying, standing = (
            model.model_validate({"rotate": degrees} | name).renditions for degrees in (0, 90)
        )
        assert [(one.height, one.width) for one in standing] == [
            (one.width, one.height) for one in lying
        ]
        # A ladder that was serialised, as for another process, is not turned twice.
        written = model.model_validate({"rotate": 90} | name).model_dump()
        assert model.model_validate(written).renditions == standing
        assert all(above.bitrate_bps > below.bitrate_bps for above, below in pairwise(standing))


def test_a_ladder_that_lies_under_a_picture_that_stands_is_refused() -> None:
    """A configured ladder that would squash the turned picture is refused."""
    lying = VideoSettings().model_dump()
    for degrees in (90, 270):
        with pytest.raises(
            ValueError, match=r"480x640, and a rendition is 640x480; swap its width"
        ):
            VideoSettings.model_validate(lying | {"rotate": degrees})
    assert VideoSettings.model_validate(lying | {"rotate": 180}).renditions[0].width == 640


def test_a_turned_camera_rests_as_it_would_upright() -> None:
    """It is left unread for as long, and drops what it has queued meanwhile."""
    caught_up: list[bool] = []
    robot = SidewaysRobot()
    assert Upright(robot, 1, mirror=False).rest_s is None
    Upright(robot, 1, mirror=False).catch_up()
    robot.rest_s, robot.catch_up = 0.9, lambda: caught_up.append(True)  # type: ignore[attr-defined]
    turned_source = Upright(robot, 1, mirror=False)
    turned_source.catch_up()
    assert (turned_source.rest_s, caught_up) == (0.9, [True])


def test_the_test_card_stays_readable() -> None:
    """The test card stays upright whichever way the settings turn a camera."""
    for rotate, size in ((90, (480, 640)), (180, (640, 480))):
        view = DrivingViewSettings.model_validate({"source": "testcard", "rotate": rotate})
        sources = make_sources(view, AudioSettings(source="none"), SystemClock(), SidewaysRobot())
        source = sources.video
        assert isinstance(source, TestCardVideo)
        source.open()
        picture = source.read()
        assert (picture.width, picture.height) == size
        assert read_stamp(picture) is not None
        source.close()
    assert read_stamp(Upright(_Card(picture), 2, mirror=False).read()) is None


class _Card(SidewaysRobot):
    """A camera that delivers one picture."""

    def __init__(self, picture: Picture) -> None:
        self._picture = picture

    def read(self) -> Picture:
        return self._picture
