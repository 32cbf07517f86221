"""A rover by MAVLink keeps the promises of `wax.testing`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

import pytest
from tests.robot.mavlink.conftest import settings

from wax.robot.find_driver import make_driver, make_robot
from wax.testing import DriverSafety

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tests.robot.mavlink.conftest import Rig

    from wax.clock import Clock
    from wax.driver.interface import Driver, Twist

pytestmark = [
    pytest.mark.system,
    pytest.mark.full,
    pytest.mark.timeout(300),
]  # the first test builds the rover


class TestGuided(DriverSafety):
    """Driven by velocities, observed at the rover."""

    mode: ClassVar = "guided"
    make: ClassVar[Any] = staticmethod(make_driver)

    @pytest.fixture(autouse=True)
    def _robot(self, rig: Rig) -> None:
        self.rig = rig
        # A driver's process takes longer to restart than the rover's usual failsafe waits.
        self.rover = rig.rover(mode=self.mode, FS_GCS_TIMEOUT=60.0)

    def make_driver(self, clock: Clock) -> Driver:
        driver: Driver = self.make(settings(url=self.rig.here, mode=self.mode), clock)
        return driver

    def commanded(self) -> Sequence[Twist]:
        return self.rover.new_setpoints()

    def cut(self) -> None:
        self.rover.command("mute", "deaf")

    def mend(self) -> None:
        self.rover.command("hear")


class TestManual(TestGuided):
    """Driven by a pilot's sticks."""

    mode = "manual"


class TestGuidedInItsProcess(TestGuided):
    """The same in a process of its own, as in the server."""

    make = staticmethod(make_robot)
