"""The simulated robot with its cameras and microphone."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, Literal

import numpy as np
import pytest

from wax.clock import SystemClock
from wax.config.robot import RobotSettings
from wax.config.video import VideoSettings
from wax.driver.interface import (
    HasCamera,
    HasExternalView,
    HasMicrophone,
    KnowsItsView,
    Pose,
    Twist,
)
from wax.errors import SourceError
from wax.robot.simulated.camera import SimulatedCamera
from wax.robot.simulated.external_view import ExternalView
from wax.robot.simulated.flat import furnished_flat
from wax.robot.simulated.microphone import SimulatedMicrophone
from wax.robot.simulated.motion import RADIUS_M
from wax.robot.simulated.render import Renderer
from wax.robot.simulated.robot import SimulatedRobot
from wax.robot.simulated.simulation import Senses
from wax.robot.simulated.speaker import SimulatedSpeaker
from wax.robot.simulated.view import View

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tests.robot.conftest import FakeClock

SMALL = VideoSettings(width=160, height=120, fps=60.0)


@pytest.fixture
def robot() -> Iterator[SimulatedRobot]:
    robot = SimulatedRobot(RobotSettings(), SystemClock())
    yield robot
    robot.close()


def test_it_has_cameras_and_a_microphone(robot: SimulatedRobot) -> None:
    """The server finds the robot's own cameras and microphone."""
    assert isinstance(robot, HasCamera)
    assert isinstance(robot, HasMicrophone)
    assert isinstance(robot, HasExternalView)


@pytest.mark.parametrize("distance_m", [0.8, 1.5, 4.0])
def test_it_knows_how_its_camera_sees_the_floor(robot: SimulatedRobot, distance_m: float) -> None:
    """Its pictures are drawn by what it reports of its camera."""
    assert isinstance(robot, KnowsItsView)
    told = robot.own_view
    drawn = View(Pose(0.0, 0.0, 0.0), 0.0, 640, 480)
    focal_px = 320 / math.tan(math.radians(told.fov_deg) / 2)
    row = 480 * told.axis_row + focal_px * math.tan(
        math.atan2(told.height_m, distance_m) - math.radians(told.tilt_deg)
    )
    depth = np.full(640, distance_m, np.float32)
    assert drawn.row(0.0, depth)[320] == pytest.approx(row, abs=0.01)
    right_m = told.width_m / 2
    column = 320 + focal_px * right_m / distance_m
    assert drawn.aside[int(column)] * distance_m == pytest.approx(right_m, abs=0.01)
    assert told.width_m == 2 * RADIUS_M


def test_what_it_sees_and_hears_changes_when_it_moves(robot: SimulatedRobot) -> None:
    """Driving changes the picture and is heard; pictures are fresh and of the configured size."""
    clock = SystemClock()
    camera, microphone = robot.camera(SMALL, clock), robot.microphone(clock)
    robot.open()
    camera.open()
    microphone.open()
    before, still = camera.read(), microphone.read()
    while robot.state().extra["speed_mps"] < 0.3:
        robot.apply(Twist(0.6, 0.5), 1)
        microphone.read()
    after = camera.read()
    assert (after.width, after.height) == (160, 120)
    assert 0.0 <= clock.now_s() - after.captured_s < 1.0
    assert after.captured_s > before.captured_s
    assert np.mean(before.i420 != after.i420) > 0.02
    assert np.std(microphone.read().samples) > 0
    assert still.samples.shape == (480, 2)
    camera.close()
    microphone.close()


@pytest.mark.parametrize("base", ["differential", "omni"])
def test_it_tells_of_a_speed_sideways_that_it_can_have(
    base: Literal["differential", "omni"], clock: FakeClock
) -> None:
    """Only a robot whose base moves sideways has that limit, and reports that speed."""
    robot = SimulatedRobot(RobotSettings(base=base), clock)
    can = base == "omni"
    assert (robot.limits.lateral_mps > 0) == can
    robot.open()
    robot.apply(Twist(lateral_mps=-0.1), 1)
    clock.time_s += 0.2
    assert robot.state().extra.get("lateral_mps") == (-0.1 if can else None)
    robot.close()


def test_camera_and_microphone_outlive_the_robot(robot: SimulatedRobot) -> None:
    """Before open and after close they deliver what a standing robot sees and hears."""
    camera, microphone = robot.camera(SMALL, SystemClock()), robot.microphone(SystemClock())
    camera.open()
    microphone.open()
    first = camera.read()
    robot.open()
    robot.close()
    assert np.array_equal(camera.read().i420, first.i420)
    assert microphone.read().samples.any()
    for source in (camera, microphone):
        source.close()
        source.close()
        with pytest.raises(SourceError, match="before it was opened"):
            source.read()


def test_each_open_begins_at_standstill(robot: SimulatedRobot) -> None:
    """Each open raises the epoch, and an earlier set-point moves nothing."""
    robot.open()
    epoch = robot.state().epoch
    robot.close()
    robot.apply(Twist(0.6, 0.0), 1)
    robot.open()
    assert robot.state().epoch == epoch + 1
    assert robot.state().extra["speed_mps"] == 0.0
    robot.apply(Twist(0.0, 0.0), 1)
    assert robot.state().extra["speed_mps"] == 0.0


def test_the_camera_keeps_its_rate(clock: FakeClock) -> None:
    """Pictures come at the configured rate, stamped with the pose's time."""
    pose = Pose(1.0, 1.0, 0.0)
    camera = SimulatedCamera(
        VideoSettings(width=32, height=32, fps=25.0),
        clock,
        artist=partial(Renderer, furnished_flat()),
        look=lambda: Senses(clock.now_s() - 0.004, pose),
    )
    camera.open()
    # The camera sleeps on real time; on this clock each beat is already due.
    stamps = []
    for _ in range(5):
        clock.time_s += 0.04
        stamps.append(camera.read().captured_s)
    camera.close()
    assert np.diff(stamps) == pytest.approx([0.04] * 4)
    assert stamps[0] == pytest.approx(1000.036)


def test_sound_has_no_gap(clock: FakeClock) -> None:
    """Each block is stamped with its beginning, which is where the last one ended."""
    ear = SimulatedMicrophone(
        clock, world=furnished_flat(), listen=lambda: Senses(clock.now_s(), Pose(1.0, 1.0, 0.0))
    )
    ear.open()
    stamps = []
    for late_s in (0.01, 0.015, 0.0075, 0.01):
        clock.time_s += late_s
        stamps.append(ear.read().captured_s)
    ear.close()
    assert stamps == pytest.approx([1000.0, 1000.01, 1000.02, 1000.03])


def test_after_a_rest_the_robot_hears_what_is_said_now(clock: FakeClock) -> None:
    """Neither time nor speech of the rest is made up for."""
    speaker = SimulatedSpeaker()
    ear = SimulatedMicrophone(
        clock,
        world=furnished_flat(),
        listen=lambda: Senses(clock.now_s(), Pose(1.0, 1.0, 0.0)),
        speaker=speaker,
    )
    ear.open()
    speaker.write(np.full(4800, 30_000, np.int16))
    clock.time_s += 0.2
    ear.catch_up()
    clock.time_s += 0.01
    heard = ear.read()
    assert heard.captured_s == pytest.approx(1000.2)
    assert np.abs(heard.samples).max() < 10_000
    speaker.write(np.full(4800, 30_000, np.int16))
    clock.time_s += 0.01
    assert np.abs(ear.read().samples).max() > 10_000
    ear.close()


def test_the_view_from_above_shows_where_it_is(robot: SimulatedRobot) -> None:
    """The external view changes only where the robot was and is."""
    flat = furnished_flat()
    size = VideoSettings(width=640, height=576, fps=60.0)  # the flat's own shape
    places = [Pose(1.1, 0.9, 0.0), Pose(7.0, 5.2, 1.0)]
    artist = partial(ExternalView, flat)
    seen = []
    for pose in places:
        look = partial(Senses, 3.0, pose)
        view = SimulatedCamera(size, SystemClock(), artist=artist, look=look)
        view.open()
        picture = view.read()
        view.close()
        assert picture.captured_s == 3.0
        seen.append(picture.i420[: picture.height].astype(int))
    rows, columns = np.nonzero(np.abs(seen[0] - seen[1]) > 20)
    at_m = np.stack([columns / 64, flat.depth - rows / 64], axis=1)
    for pose in places:
        assert np.hypot(*(at_m - (pose.x_m, pose.y_m)).T).min() < 0.1
    nearest = [np.hypot(*(at_m - (pose.x_m, pose.y_m)).T) for pose in places]
    assert np.minimum(*nearest).max() < 0.8
    with pytest.raises(SourceError):
        robot.external_view(size, SystemClock()).read()
