"""The driver for ROS 2 against a base on CycloneDDS in another process."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar

import pytest
from tests.robot.ros2.base import Base, own_domain
from tests.robot.ros2.robots import ros2_settings

from wax.driver.interface import Limits
from wax.robot.find_driver import make_driver, make_robot
from wax.testing import DriverSafety

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from wax.clock import Clock
    from wax.driver.interface import Driver, Twist

pytest.importorskip("cyclonedds", reason='type: pip install "wax-teleop[ros2]"')
pytestmark = [pytest.mark.system, pytest.mark.full, pytest.mark.timeout(120)]


class TestByDds(DriverSafety):
    """Observed by the base's commands."""

    own: ClassVar[dict[str, Any]] = {}
    make = staticmethod(make_driver)
    lateral_mps: ClassVar = 0.0

    @pytest.fixture(autouse=True)
    def _robot(self) -> Iterator[None]:
        self.domain = own_domain()
        self.base = Base(self.domain).start()
        yield
        self.base.end()

    def make_driver(self, clock: Clock) -> Driver:
        return self.make(ros2_settings(self.domain, **self.own), clock)

    def commanded(self) -> Sequence[Twist]:
        return [told.twist for told in self.base.forget()]

    def cut(self) -> None:
        self.base.end()

    def mend(self) -> None:
        self.base.start()

    def test_it_is_what_was_configured(self, driver: Driver) -> None:
        """Kind and limits are known before it is opened; without a known timeout it has none."""
        assert driver.kind == "ros2"
        limits = replace(driver.limits, silence_s=None)
        assert limits == Limits(0.6, 1.5, lateral_mps=self.lateral_mps)


class TestByDdsInItsProcess(TestByDds):
    """A base that moves sideways, too."""

    own: ClassVar[dict[str, Any]] = {"base": "mecanum"}
    make = staticmethod(make_robot)
    lateral_mps = 0.6


class TestByDdsWithoutStandby(TestByDds):
    own: ClassVar[dict[str, Any]] = {"standby": False}
