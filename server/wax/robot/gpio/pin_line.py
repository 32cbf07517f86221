"""The pins as a line: opened, given the newest set-point, and read."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from wax.driver.interface import Reading
from wax.robot.gpio.odometry import StepOdometry
from wax.robot.gpio.shares import MotorOpening, unless_bumped
from wax.robot.line.kept_line import RobotLine
from wax.robot.wheels import WheelGeometry
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.config.robot import RobotSettings
    from wax.driver.interface import Twist
    from wax.robot.gpio.guard import Guard
    from wax.robot.gpio.pins import Pins
    from wax.robot.gpio.settings import GpioSettings
    from wax.robot.line.core import LineCore

LOOK_EVERY_S: Final = 0.02
"""How often encoders are read."""


class PinLine(RobotLine):
    """The pins; closing them switches the motors off, so they need no farewell."""

    _pins: Pins
    _odometry: StepOdometry

    def __init__(self, robot: RobotSettings, settings: GpioSettings, core: LineCore) -> None:
        self._settings = settings
        self._wheels = WheelGeometry(robot)
        self._opening = MotorOpening(robot, settings)
        self._core = core
        self._turned: dict[str, float] = {}
        self._guard: Guard | None = None

    def start(self) -> None:
        from wax.robot.gpio.guard import Guard  # noqa: PLC0415 - not before it is wanted

        bridge_pins = [pin for pins in self._settings.motors[1].values() for pin in pins]
        self._guard = Guard(bridge_pins) if self._settings.guard else None

    def open(self, wake: Callable[[], None]) -> None:
        # gpiozero is an optional dependency, and slow to load.
        from wax.robot.gpio.pins import Pins  # noqa: PLC0415

        self._pins = Pins(self._settings, wake)

    def begin(self, now_s: float) -> None:
        self._turned.clear()
        self._odometry = StepOdometry(self._settings.steps_per_m, self._wheels)
        self._core.opened(now_s)

    def step(self, now_s: float) -> float:
        """Apply the set-point to the pins, and read the inputs."""
        order, changes_s = self._core.order(now_s)
        self._drive(order.twist)
        for name, position in order.axes:
            if self._turned.get(name) != position:
                self._pins.turn(name, position)
                self._turned[name] = position
        self._core.heard(self._look(now_s))
        return min(changes_s, now_s + LOOK_EVERY_S)

    def close(self) -> None:
        self._pins.close()

    def end(self) -> None:
        if self._guard is not None:
            self._guard.dismiss()

    def problem(self, error: Exception, *, was_open: bool) -> Sentence:
        seconds = self._settings.reopen_s
        return Sentence(
            "gpio.lost" if was_open else "gpio.not_open", {"why": _why(error), "seconds": seconds}
        )

    def _drive(self, wanted: Twist) -> None:
        front, back = self._pins.bumped if self._settings.bumpers_stop else (False, False)
        twist = unless_bumped(wanted, front=front, back=back)
        self._pins.drive(self._opening.shares(twist))
        self._pins.set_directions(self._opening.directions(twist))

    def _look(self, now_s: float) -> Reading:
        steps, bumpers = self._pins.steps, self._pins.bumpers
        if steps is None:
            return Reading(bumpers=bumpers)
        odometry = self._odometry
        odometry.take(steps, now_s)
        motion = odometry.motion
        extra = {
            f"{wheel}_steps": float(one)
            for wheel, one in zip(self._wheels.names, steps, strict=True)
        }
        extra["speed_mps"] = motion.linear_mps
        if self._wheels.moves_sideways:
            extra["lateral_mps"] = motion.lateral_mps
        return Reading(moving=odometry.moving, pose=odometry.pose, bumpers=bumpers, extra=extra)


def _why(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__
