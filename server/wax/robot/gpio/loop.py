"""Keeps the pins open and applies the newest set-point to them, in one thread."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Final

from wax.driver.interface import RobotState
from wax.robot.gpio.odometry import StepOdometry
from wax.robot.gpio.shares import OFF, MotorOpening, unless_bumped
from wax.robot.line.setpoints import SetPoints
from wax.sentence import Sentence

if TYPE_CHECKING:
    from collections.abc import Callable

    from wax.clock import Clock
    from wax.config.robot import RobotSettings
    from wax.driver.interface import Limits, Twist
    from wax.robot.gpio.guard import Guard
    from wax.robot.gpio.pins import Pins
    from wax.robot.gpio.settings import GpioSettings

SETPOINT_TTL_S: Final = 0.2
"""The driver's process repeats the set-point 50 times a second."""
LOOK_EVERY_S: Final = 0.02
"""How often encoders are read."""
CLOSE_TIMEOUT_S: Final = 0.8


class PinLoop:
    """Keeps the pins open from `open` to `close`, reopening them after failures."""

    def __init__(
        self, robot: RobotSettings, settings: GpioSettings, limits: Limits, clock: Clock
    ) -> None:
        self._settings = settings
        self._wheel_base_m = robot.wheel_base_m
        self._clock = clock
        self._opening = MotorOpening(robot, settings)
        self._changed = threading.Condition()
        self._setpoints = SetPoints(limits, SETPOINT_TTL_S)
        self._news = False
        self._closing = False
        self._thread: threading.Thread | None = None
        self._state = RobotState(connected=False)
        self._epoch = 0
        self._turned: dict[str, float] = {}

    # --- from the driver --------------------------------------------------------------------

    def open(self) -> None:
        """Start opening the pins and keep trying; no effect if already started."""
        if self._thread is not None:
            return
        self._closing = False
        self._thread = threading.Thread(target=self._keep, name="pins", daemon=True)
        self._thread.start()

    def change(self, how: Callable[[SetPoints], None]) -> None:
        """Change the set-points and apply the change to the pins at once."""
        with self._changed:
            how(self._setpoints)
            self._news = True
            self._changed.notify()

    def close(self) -> None:
        """Switch off and release the pins; takes at most a second, safe to call twice."""
        thread, self._thread = self._thread, None
        if thread is None:
            return
        with self._changed:
            self._closing = True
            self._changed.notify()
        thread.join(CLOSE_TIMEOUT_S)

    def state(self) -> RobotState:
        return self._state

    # --- the thread -------------------------------------------------------------------------

    def _keep(self) -> None:
        from wax.robot.gpio.guard import Guard  # noqa: PLC0415 - not before it is wanted

        bridge_pins = [pin for pins in self._settings.motors[1:] for pin in pins]
        guard = Guard(bridge_pins) if self._settings.guard else None
        try:
            while not self._closing:
                problem = self._use()
                self._lost(problem)
                with self._changed:
                    self._changed.wait_for(lambda: self._closing, self._settings.reopen_s)
        finally:
            self._lost(None)
            _dismiss(guard)

    def _use(self) -> Sentence | None:
        """Open the pins and use them until they are closed or fail; return why they failed."""
        # gpiozero is an optional dependency, and slow to load.
        from wax.robot.gpio.pins import Pins  # noqa: PLC0415

        try:
            pins = Pins(self._settings, self._bumped)
        except Exception as error:  # gpiozero's, or what a library of the pins raises
            return Sentence(
                "gpio.not_open", {"why": _why(error), "seconds": self._settings.reopen_s}
            )
        with self._changed:
            self._setpoints.connected()
            self._epoch += 1
            self._turned.clear()
        odometry = StepOdometry(self._settings.steps_per_m, self._wheel_base_m)
        try:
            while not self._closing:
                self._step(pins, odometry)
        except Exception as error:
            return Sentence("gpio.lost", {"why": _why(error), "seconds": self._settings.reopen_s})
        finally:
            pins.close()
        return None

    def _step(self, pins: Pins, odometry: StepOdometry) -> None:
        """Apply the set-point to the pins, read the inputs, and wait for a change."""
        now_s = self._clock.now_s()
        with self._changed:
            self._news = False
            order, changes_s = self._setpoints.order(now_s)
        self._drive(pins, order.twist)
        for name, position in order.axes:
            if self._turned.get(name) != position:
                pins.turn(name, position)
                self._turned[name] = position
        self._look(pins, odometry, now_s)
        with self._changed:
            pause_s = min(changes_s - self._clock.now_s(), LOOK_EVERY_S)
            self._changed.wait_for(lambda: self._news or self._closing, max(0.0, pause_s))

    def _drive(self, pins: Pins, wanted: Twist) -> None:
        front, back = pins.bumped if self._settings.bumpers_stop else (False, False)
        twist = unless_bumped(wanted, front=front, back=back)
        shares = OFF if twist.is_zero else self._opening.shares(twist)
        pins.drive(shares)
        pins.set_directions(*self._opening.directions(twist))

    def _look(self, pins: Pins, odometry: StepOdometry, now_s: float) -> None:
        steps = pins.steps
        extra: dict[str, float] = {}
        if steps is not None:
            odometry.take(steps, now_s)
            extra = {
                "left_steps": float(steps[0]),
                "right_steps": float(steps[1]),
                "speed_mps": odometry.speed_mps,
            }
        self._state = RobotState(
            connected=True,
            epoch=self._epoch,
            moving=None if steps is None else odometry.moving,
            pose=None if steps is None else odometry.pose,
            bumpers=pins.bumpers,
            extra=extra,
        )

    def _bumped(self) -> None:
        """Read the bumpers now; called by a thread of gpiozero's."""
        with self._changed:
            self._news = True
            self._changed.notify()

    def _lost(self, problem: Sentence | None) -> None:
        with self._changed:
            self._setpoints.lost()
        self._state = RobotState(connected=False, problem=problem, epoch=self._epoch)


def _why(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__


def _dismiss(guard: Guard | None) -> None:
    if guard is not None:
        guard.dismiss()
