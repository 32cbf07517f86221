"""The driver for a robot whose motors are wired to this computer's GPIO pins."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wax.driver.interface import Limits
from wax.robot.gpio.loop import PinLoop
from wax.robot.gpio.settings import GpioSettings

if TYPE_CHECKING:
    from wax.clock import Clock
    from wax.config.robot import RobotSettings
    from wax.driver.interface import RobotState, Twist


class GpioRobot:
    """A `Driver` for two motors on H-bridges, servos, encoders and bumpers.

    Pins have no watchdog of their own (`ttl_s` is None): this driver switches the motors off when
    set-points cease, the driver process when the server is silent, and `guard` when that process
    has died.
    """

    Settings = GpioSettings

    def __init__(self, settings: RobotSettings, clock: Clock) -> None:
        import gpiozero  # noqa: F401, PLC0415 - said at the start where it is missing

        own = settings.own(GpioSettings)
        self._limits = Limits(
            settings.max_linear_mps, settings.max_angular_rps, axes=tuple(own.servos)
        )
        self._clock = clock
        self._loop = PinLoop(settings, own, self._limits, clock)

    @property
    def kind(self) -> str:
        return "gpio"

    @property
    def limits(self) -> Limits:
        return self._limits

    def open(self) -> None:
        """Start opening the pins; `state` reports whether they are open."""
        self._loop.open()

    def apply(self, twist: Twist, turn: int) -> None:
        now_s = self._clock.now_s()
        self._loop.change(lambda setpoints: setpoints.apply(twist, turn, now_s))

    def set_axis(self, name: str, position: float, turn: int) -> None:
        self._loop.change(lambda setpoints: setpoints.set_axis(name, position, turn))

    def stop(self, turn: int) -> None:
        self._loop.change(lambda setpoints: setpoints.stop(turn))

    def close(self) -> None:
        self._loop.close()

    def state(self) -> RobotState:
        return self._loop.state()
