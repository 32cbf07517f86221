"""The pins, by gpiozero: motors, servos, encoders and bumpers."""

from __future__ import annotations

import contextlib
import os
import tempfile
from typing import TYPE_CHECKING, Any, Final

import gpiozero

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from wax.robot.gpio.settings import Bridge, GpioSettings

Steps = tuple[int, ...]

_SERVO_FRAME_S: Final = 0.02


class Motor:
    """One motor; gpiozero's own classes lack separate direction and speed pins, or a frequency."""

    def __init__(self, bridge: Bridge, pins: list[int], pwm_hz: float) -> None:
        self._parts: list[Any] = []
        self._share = 0.0
        self._ahead = self._back = None
        try:
            if bridge == "in_in":
                self._ahead = self._pwm(pins[0], pwm_hz)
                self._back = self._pwm(pins[1], pwm_hz)
            elif bridge == "phase_enable":
                self._directions = (None, self._level(pins[0]))
                self._speed = self._pwm(pins[1], pwm_hz)
            else:
                self._directions = (self._level(pins[0]), self._level(pins[1]))
                self._speed = self._pwm(pins[2], pwm_hz)
        except Exception:
            self.close()
            raise

    def set(self, share: float) -> None:
        """Set the duty cycle; a change of direction switches the motor off for a moment."""
        if share == self._share:
            return  # restarting the same PWM would make the motor jerk
        if share * self._share <= 0.0:
            self.off()
        if self._ahead is not None and self._back is not None:
            (self._ahead if share > 0.0 else self._back).value = abs(share)
        elif share != 0.0:
            ahead, back = self._directions
            for part, is_on in ((ahead, share > 0.0), (back, share < 0.0)):
                if part is not None:
                    part.value = is_on
            self._speed.value = abs(share)
        self._share = share

    def off(self) -> None:
        """Switch all its pins off, the speed first."""
        for part in reversed(self._parts):
            part.off()
        self._share = 0.0

    def close(self) -> None:
        for part in reversed(self._parts):
            part.close()

    def _level(self, pin: int) -> Any:
        self._parts.append(gpiozero.DigitalOutputDevice(pin))
        return self._parts[-1]

    def _pwm(self, pin: int, pwm_hz: float) -> Any:
        self._parts.append(gpiozero.PWMOutputDevice(pin, frequency=pwm_hz))
        return self._parts[-1]


class Encoder:
    """Counts a wheel's steps: with two pins either way, with one in the direction `towards`."""

    def __init__(self, pins: list[int]) -> None:
        self.towards = 1
        self._counted = 0
        self._both: Any = None
        if len(pins) == 2:
            self._both = self._device = gpiozero.RotaryEncoder(*pins, max_steps=0)
        else:
            self._device = gpiozero.DigitalInputDevice(pins[0], pull_up=True)
            self._device.when_activated = self._count

    @property
    def steps(self) -> int:
        return self._counted if self._both is None else int(self._both.steps)

    def close(self) -> None:
        self._device.close()

    def _count(self) -> None:
        self._counted += self.towards


class Pins:
    """Everything wired to the pins, from construction to `close`; raises what gpiozero raises."""

    def __init__(self, settings: GpioSettings, on_bump: Callable[[], None]) -> None:
        # lgpio creates a pipe in the working directory, which may not be writable.
        os.environ.setdefault("LG_WD", tempfile.gettempdir())
        self._closers: list[Callable[[], None]] = []
        try:
            self._claim(settings, on_bump)
        except Exception:
            self.close()
            raise

    def _claim(self, settings: GpioSettings, on_bump: Callable[[], None]) -> None:
        bridge, motors = settings.motors
        self._motors = tuple(
            self._keep(Motor(bridge, pins, settings.pwm_hz)) for pins in motors.values()
        )
        self._servos = {
            name: self._keep(
                gpiozero.Servo(
                    pin,
                    initial_value=None,  # the servo stays where it is until its first position
                    min_pulse_width=settings.servo_min_ms / 1000.0,
                    max_pulse_width=settings.servo_max_ms / 1000.0,
                    frame_width=_SERVO_FRAME_S,
                )
            )
            for name, pin in settings.servos.items()
        }
        self._encoders = tuple(
            self._keep(Encoder(pins)) for pins in settings.encoders.values() if pins
        )
        # gpiozero's Button waits up to a second for its release before it closes.
        self._front, self._back = (
            tuple(self._keep(gpiozero.DigitalInputDevice(pin, pull_up=True)) for pin in pins)
            for pins in (settings.front_bumpers, settings.back_bumpers)
        )
        for button in (*self._front, *self._back):
            button.when_activated = button.when_deactivated = on_bump

    def drive(self, shares: Sequence[float]) -> None:
        """Set the motors' duty cycles."""
        for motor, share in zip(self._motors, shares, strict=True):
            motor.set(share)

    def set_directions(self, directions: Sequence[int]) -> None:
        """Tell encoders with one pin in which direction the wheels roll."""
        for encoder, towards in zip(self._encoders, directions, strict=False):
            encoder.towards = towards or encoder.towards

    def turn(self, name: str, position: float) -> None:
        """Turn an axis to a position."""
        self._servos[name].value = position

    @property
    def steps(self) -> Steps | None:
        """The counts of the wheels; None without encoders."""
        return tuple(encoder.steps for encoder in self._encoders) or None

    @property
    def bumped(self) -> tuple[bool, bool]:
        """Whether a bumper is pressed, in front and behind."""
        return (
            any(button.is_active for button in self._front),
            any(button.is_active for button in self._back),
        )

    @property
    def bumpers(self) -> int:
        """A bit for each pressed bumper, those in front first."""
        buttons = (*self._front, *self._back)
        return sum(1 << number for number, button in enumerate(buttons) if button.is_active)

    def close(self) -> None:
        """Switch the motors off, then release all pins; never raises."""
        for motor in getattr(self, "_motors", ()):
            with contextlib.suppress(Exception):
                motor.off()
        for close in reversed(self._closers):
            with contextlib.suppress(Exception):
                close()
        self._closers.clear()

    def _keep(self, part: Any) -> Any:
        self._closers.append(part.close)
        return part
