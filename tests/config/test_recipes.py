"""The recipes of `config/README.md` load as they are written."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

from wax.clock import SystemClock
from wax.config import settings as config
from wax.robot.build_driver import make_driver

TEXT = (Path(__file__).parents[2] / "config/README.md").read_text(encoding="utf-8")
ROBOTS = [
    text
    for text in re.findall(r"^```toml\n(.*?)^```$", TEXT, re.DOTALL | re.MULTILINE)
    if "[robot]" in text
]


@pytest.mark.parametrize("text", ROBOTS)
def test_a_robot_that_moves_sideways_is_written_in_a_few_lines(text: str) -> None:
    """Each robot of the recipes is built, and its driver has a limit sideways."""
    robot = config.parse(tomllib.loads(text), "README.md").robot
    assert make_driver(robot, SystemClock()).limits.lateral_mps == robot.lateral_mps > 0.0


def test_there_are_recipes_for_lines_and_for_ros_2() -> None:
    """Neither is lost when the text around them is written anew."""
    assert {tomllib.loads(text)["robot"]["driver"] for text in ROBOTS} >= {"serial", "ros2"}
