"""Finding the driver that the configuration names."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from wax.config import RobotSettings
from wax.errors import ConfigError
from wax.robot.find import make_driver

if TYPE_CHECKING:
    from tests.robot.conftest import FakeClock


@pytest.mark.parametrize("name", ["simulated", "serial"])
def test_ours_are_found_by_name(name: str, clock: FakeClock) -> None:
    """The driver that comes has the kind that was asked for, and is not connected yet."""
    driver = make_driver(RobotSettings(driver=name), clock)
    assert driver.kind == name
    assert not driver.state().connected


def test_anybodys_class_is_found(clock: FakeClock) -> None:
    """A driver named package.module:Class is built with settings and clock."""
    name = "wax.robot.simulated.robot:SimulatedRobot"
    assert (
        make_driver(RobotSettings(driver=name, max_linear_mps=0.2), clock).limits.linear_mps == 0.2
    )


def test_an_unknown_name_is_answered_with_what_is_possible(clock: FakeClock) -> None:
    """The sentence quotes what was asked for and lists every possibility."""
    with pytest.raises(ConfigError, match=r"'tank'.*'simulated', 'serial'.*package\.module:Class"):
        make_driver(RobotSettings(driver="tank"), clock)


def test_a_plugin_that_is_not_there_says_so(clock: FakeClock) -> None:
    """A class that cannot be imported is a ConfigError naming the key, not a traceback."""
    with pytest.raises(ConfigError, match=r"robot\.driver: no\.such:Robot: cannot import"):
        make_driver(RobotSettings(driver="no.such:Robot"), clock)
