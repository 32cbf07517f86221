"""The paths that the simulated mecanum robot drives, as the page draws them (`driven.test.ts`)."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest

from wax.config.drive import DriveSettings
from wax.config.robot import RobotSettings
from wax.control import ramp, speed
from wax.control.command import Command
from wax.control.gate import Setpoint
from wax.control.rules import Rules
from wax.control.video_freshness import VideoFreshness
from wax.driver.interface import Limits, Pose
from wax.robot.simulated.flat import furnished_flat
from wax.robot.simulated.motion import Motion, step

VECTORS = json.loads((Path(__file__).parents[1] / "vectors" / "paths.json").read_text("utf-8"))
WORLD = furnished_flat()
FREE_FLOOR = Pose(3.1, 7.25, 0.0)
STEP_S = 0.01


def driven(motion: dict[str, Any]) -> Pose:
    """Return where a second of each of these commands takes the robot, by the server's rules."""
    settings = RobotSettings(base="mecanum")
    limits = Limits(
        settings.max_linear_mps, settings.max_angular_rps, lateral_mps=settings.lateral_mps
    )
    rules = Rules.of(DriveSettings(), settings, limits)
    moved = Motion(FREE_FLOOR)
    now = Setpoint()
    for held in motion["held"]:
        command = Command(1, 1, 0.0, **held, held=True, speed="fast", seen_s=0.0)
        wanted, _ = speed.twist(command, VideoFreshness.CLEAR, 0.1, rules)
        for _ in range(round(1 / rules.period_s)):
            now = ramp.step(Setpoint(wanted), now.twist, rules.period_s, rules)
            for _ in range(round(rules.period_s / STEP_S)):
                moved = step(moved, now.twist, limits, WORLD, STEP_S)
                assert moved.impact_mps == 0.0
    return moved.pose


@pytest.mark.parametrize("motion", VECTORS["motions"], ids=lambda one: one["name"])
def test_it_drives_the_path_of_each_motion(motion: dict[str, Any]) -> None:
    """After a second of each command it is where the vector says, to a millimetre."""
    there = driven(motion)
    told = motion["driven"]
    assert there.x_m - FREE_FLOOR.x_m == pytest.approx(told["ahead_m"], abs=1e-3)
    assert there.y_m - FREE_FLOOR.y_m == pytest.approx(told["left_m"], abs=1e-3)
    assert math.remainder(there.heading_rad - told["heading_rad"], math.tau) == pytest.approx(
        0.0, abs=1e-3
    )
