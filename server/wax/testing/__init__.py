"""What every robot driver must pass: a suite to inherit in the tests of your own driver.

A driver's test is a class that makes the driver and returns what reached the robot::

    class TestMine(DriverSafety):
        @pytest.fixture(autouse=True)
        def _robot(self) -> Iterator[None]:
            self.robot = MyRobotOnTheDesk()   # the robot's end of the link
            yield
            self.robot.close()

        def make_driver(self, clock: Clock) -> Driver:
            return MyDriver(RobotSettings(driver="my_package.driver:MyDriver"), clock)

        def commanded(self) -> Sequence[Twist]:
            return self.robot.take_what_it_was_told()

        def cut(self) -> None: ...            # where the link can break
        def mend(self) -> None: ...

It needs pytest: ``pip install "wax-teleop[testing]"``. Nothing in the server imports it.
"""

from __future__ import annotations

try:
    import pytest
except ImportError as error:
    raise ImportError(
        'wax.testing needs pytest; install it by: pip install "wax-teleop[testing]"'
    ) from error

pytest.register_assert_rewrite("wax.testing.driver_safety", "wax.testing.driver_under_test")

from wax.testing.driver_safety import DriverSafety  # noqa: E402 - not before the line above

__all__ = ["DriverSafety"]
