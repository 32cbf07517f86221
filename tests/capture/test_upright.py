"""A camera that does not hang upright is shown upright."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from tests.capture.card_reader import read_stamp

from wax.capture.find_sources import make_camera, make_sources
from wax.capture.letterbox import planes
from wax.capture.source import Picture
from wax.capture.testcard import TestCardVideo
from wax.capture.upright import Upright, turned
from wax.clock import Clock, SystemClock
from wax.config.settings import AudioSettings, CameraSettings, DrivingViewSettings, VideoSettings
from wax.driver.interface import Limits, RobotState, Twist

RANDOM = np.random.default_rng(7).integers(0, 255, (48 * 3 // 2, 64), dtype=np.uint8)


@pytest.mark.parametrize("mirror", [False, True])
@pytest.mark.parametrize("quarters", range(4))
def test_each_plane_is_turned_and_then_mirrored(quarters: int, mirror: bool) -> None:
    """Luma and chroma turn clockwise; left and right are swapped in the picture that is upright."""
    found = turned(RANDOM, quarters, mirror=mirror)
    for before, after in zip(planes(RANDOM), planes(found), strict=True):
        upright = np.rot90(before, -quarters)
        assert (after == (upright[:, ::-1] if mirror else upright)).all()


class SidewaysRobot:
    """A driver whose cameras give a picture of odd proportions, at a moment."""

    kind = "sideways"
    limits = Limits(1.0, 1.0)

    def camera(self, settings: VideoSettings, clock: Clock) -> SidewaysRobot:
        return self

    external_view = camera

    def read(self) -> Picture:
        return Picture(RANDOM, 77.0, within_s=0.02)

    def open(self) -> None: ...

    def apply(self, twist: Twist, turn: int) -> None: ...

    def set_axis(self, name: str, position: float, turn: int) -> None: ...

    def stop(self, turn: int) -> None: ...

    def close(self) -> None: ...

    def state(self) -> RobotState:
        return RobotState(connected=True)


@pytest.mark.parametrize(
    ("rotate", "mirror", "size"),
    [(0, False, (64, 48)), (90, False, (48, 64)), (180, True, (64, 48)), (270, True, (48, 64))],
)
def test_every_camera_is_turned_as_its_table_says(
    rotate: int, mirror: bool, size: tuple[int, int]
) -> None:
    """The driving view and a camera beside it turn by their own settings; their time stays."""
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
    """Who turns a camera by a quarter gets the ladder upright, and their own as they wrote it."""
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
        # What was written out, as for another process, is not turned once more.
        written = model.model_validate({"rotate": 90} | name).model_dump()
        assert model.model_validate(written).renditions == standing
        assert all(above.bitrate_bps > below.bitrate_bps for above, below in pairwise(standing))


def test_a_ladder_that_lies_under_a_picture_that_stands_is_refused() -> None:
    """Who wrote a ladder of their own is told to turn it, too, for it would squash the picture."""
    lying = VideoSettings().model_dump()
    for degrees in (90, 270):
        with pytest.raises(
            ValueError, match=r"480x640, and a rendition is 640x480; swap its width"
        ):
            VideoSettings.model_validate(lying | {"rotate": degrees})
    assert VideoSettings.model_validate(lying | {"rotate": 180}).renditions[0].width == 640


def test_the_test_card_stays_readable() -> None:
    """A measurement reads the test card's time whichever way the camera is said to hang."""
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
    """A camera that gives one picture."""

    def __init__(self, picture: Picture) -> None:
        self._picture = picture

    def read(self) -> Picture:
        return self._picture
