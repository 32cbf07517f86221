"""The table `[robot.gpio]`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar, Final, Literal, Self

from pydantic import Field, model_validator

from wax.config.bases import WHEELS, WHEELS_OF
from wax.config.driver_settings import DriverSettings
from wax.config.table import Name

if TYPE_CHECKING:
    from wax.config.bases import Base

Pin = Annotated[int, Field(ge=0, le=27)]
Pins = Annotated[list[Pin], Field(max_length=3)]
EncoderPins = Annotated[list[Pin], Field(max_length=2)]
Bridge = Literal["in_in_pwm", "in_in", "phase_enable"]

PINS_OF: Final[dict[Bridge, int]] = {"in_in_pwm": 3, "in_in": 2, "phase_enable": 2}

BOARDS: Final[dict[str, tuple[Bridge, list[int], list[int]]]] = {
    "camjam": ("in_in", [9, 10], [7, 8]),
    "ryanteck": ("in_in", [17, 18], [22, 23]),
    "drv8835": ("phase_enable", [5, 12], [6, 13]),
}
"""Boards whose pins gpiozero knows: the bridge, the left and the right motor."""


class GpioSettings(DriverSettings):
    """Motors on H-bridges, and whatever else is wired to the pins; all numbers are BCM's."""

    TABLE: ClassVar[str] = "gpio"

    board: Literal["own", "camjam", "ryanteck", "drv8835"] = "own"
    """A motor board whose pins are known (CamJam EduKit 3, Ryanteck, Pololu DRV8835), or "own" with
    bridge, left and right below."""
    bridge: Bridge = "in_in_pwm"
    """What a motor's pins are: in_in_pwm (IN1, IN2, PWM: TB6612, L298N), in_in (both IN with PWM:
    DRV8833, L9110) or phase_enable (direction, then PWM)."""
    left: Pins = [17, 27, 12]
    """The left motor's pins, as bridge says. Take some from 9 on: those below are pulled up while
    nobody drives them."""
    right: Pins = [23, 24, 13]
    """The right motor's pins."""
    front_left: Pins = []
    """The pins of a mecanum base's motors, in place of left and right: this one's, and those of the
    next three."""
    front_right: Pins = []
    """The pins of the motor in front on the right."""
    back_left: Pins = []
    """The pins of the motor behind on the left."""
    back_right: Pins = []
    """The pins of the motor behind on the right."""
    back: Pins = []
    """The pins of an omni base's third motor, which drives its back to the left."""
    pwm_hz: Annotated[float, Field(ge=20.0, le=10_000.0)] = 500.0
    """The frequency of the motors' PWM in hertz, which gpiozero's pins make in software."""
    full_speed_mps: Annotated[float, Field(ge=0.0, le=10.0)] = 0.0
    """The speed of a wheel at full voltage in metres a second, as measured. 0: as fast as the
    limits of [robot] ask for."""
    dead_share: Annotated[float, Field(ge=0.0, le=0.9)] = 0.0
    """The share of the voltage below which the motors only hum."""
    servos: Annotated[dict[Name, Pin], Field(max_length=4)] = {}
    """The axes that servos turn, each with its pin: { pan = 18, tilt = 19 }."""
    servo_min_ms: Annotated[float, Field(ge=0.4, le=1.5)] = 1.0
    """The pulse in milliseconds for an axis at -1."""
    servo_max_ms: Annotated[float, Field(ge=1.5, le=2.6)] = 2.0
    """The pulse in milliseconds for an axis at 1."""
    left_encoder: EncoderPins = []
    """The left wheel's encoder: A and B, or only A, which counts in the direction that the motor is
    told. Empty: none."""
    right_encoder: EncoderPins = []
    """The right wheel's encoder; all wheels have one or none has."""
    front_left_encoder: EncoderPins = []
    """The encoders of a mecanum base's wheels, in place of left_encoder and right_encoder: this
    one's, and those of the next three."""
    front_right_encoder: EncoderPins = []
    """The encoder of the wheel in front on the right."""
    back_left_encoder: EncoderPins = []
    """The encoder of the wheel behind on the left."""
    back_right_encoder: EncoderPins = []
    """The encoder of the wheel behind on the right."""
    back_encoder: EncoderPins = []
    """The encoder of an omni base's third wheel."""
    steps_per_m: Annotated[float, Field(gt=0.0, le=100_000.0)] = 1000.0
    """How many steps an encoder counts while its wheel rolls a metre."""
    front_bumpers: Annotated[list[Pin], Field(max_length=4)] = []
    """The buttons in front, each between its pin and ground."""
    back_bumpers: Annotated[list[Pin], Field(max_length=4)] = []
    """The buttons behind."""
    bumpers_stop: bool = True
    """Whether a pressed bumper stops the robot here, in the driver: towards it nothing moves then,
    away from it and on the spot it may."""
    guard: bool = True
    """Whether a second process waits to clear the motors' pins when the driver's own has died: pins
    have no watchdog, and keep their last level."""
    reopen_s: Annotated[float, Field(ge=0.05, le=60.0)] = 1.0
    """Seconds before pins that failed are tried again."""

    @property
    def base(self) -> Base:
        """The base whose motors are given."""
        if any(getattr(self, wheel) for wheel in WHEELS_OF["mecanum"]):
            return "mecanum"
        return "omni" if self.back else "differential"

    @property
    def motors(self) -> tuple[Bridge, dict[str, list[int]]]:
        """The bridge, and the pins of each wheel's motor."""
        if self.board == "own":
            return self.bridge, {wheel: getattr(self, wheel) for wheel in WHEELS_OF[self.base]}
        bridge, left, right = BOARDS[self.board]
        return bridge, {"left": left, "right": right}

    @property
    def encoders(self) -> dict[str, list[int]]:
        """The pins of each wheel's encoder."""
        return {wheel: getattr(self, f"{wheel}_encoder") for wheel in WHEELS_OF[self.base]}

    @model_validator(mode="after")
    def _is_whole(self) -> Self:
        bridge, motors = self.motors
        wheels = WHEELS_OF[self.base]
        if len(motors) != len(wheels):
            raise ValueError(f'board "{self.board}" has two motors; for more it must be "own"')
        for name, pins in motors.items():
            if len(pins) != PINS_OF[bridge]:
                raise ValueError(
                    f"{name} has {len(pins)} pins; a motor on {bridge} has {PINS_OF[bridge]}"
                )
        for name in (wheel for wheel in WHEELS if wheel not in wheels):
            for key in (name, f"{name}_encoder"):
                if getattr(self, key) != type(self).model_fields[key].default:
                    raise ValueError(
                        f"{key} is no wheel beside {' and '.join(wheels)}; leave it out"
                    )
        without = [f"{wheel}_encoder" for wheel, pins in self.encoders.items() if not pins]
        if without and len(without) != len(wheels):
            raise ValueError(f"{without[0]} is missing; all wheels have an encoder, or none has")
        self._no_pin_twice()
        return self

    def _no_pin_twice(self) -> None:
        users: dict[int, str] = {}
        for name, pins in {
            **self.motors[1],
            "servos": list(self.servos.values()),
            **{f"{wheel}_encoder": pins for wheel, pins in self.encoders.items()},
            "front_bumpers": self.front_bumpers,
            "back_bumpers": self.back_bumpers,
        }.items():
            for pin in pins:
                if pin in users:
                    raise ValueError(
                        f"pin {pin} is used twice, for {users[pin]} and {name}; give each its own"
                    )
                users[pin] = name
