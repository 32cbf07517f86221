"""`[robot]`: its driver, its limits and its wheels."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal, Self, TypeVar

from pydantic import ConfigDict, Field, model_validator

from wax.config.bases import Base
from wax.config.serial import SerialSettings
from wax.config.table import ConfigTable

if TYPE_CHECKING:
    from wax.config.driver_settings import DriverSettings


OwnT = TypeVar("OwnT", bound="DriverSettings")


class RobotSettings(ConfigTable):
    """The robot, its limits and its wheels."""

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, dict[str, Any]] = Field(init=False)

    driver: Annotated[str, Field(min_length=1)] = "simulated"
    """The robot: "simulated", "serial", another driver that `wax devices` lists, or your own class
    as "package.module:Class". A driver may bring keys of its own, in a table [robot.NAME]: `wax
    config` shows them."""
    max_linear_mps: Annotated[float, Field(gt=0, le=10)] = 0.6
    """The highest speed forward or back, in metres a second. 0.6 is a stroll, safe indoors."""
    max_angular_rps: Annotated[float, Field(gt=0, le=20)] = 1.5
    """The highest turning speed, in radians a second. 1.5 is a quarter turn a second: at more,
    people overshoot when the picture is 200 ms late."""
    base: Base = "differential"
    """How the robot's wheels are arranged: two driven sides, four mecanum wheels, or three omni
    wheels at equal angles, of which one is at the back. A driver whose robot mixes its wheels
    itself ignores it."""
    max_lateral_mps: Annotated[float, Field(ge=0, le=10)] | Literal["auto"] = "auto"
    """The highest speed sideways, in metres a second; 0 is a robot that cannot. "auto" is
    max_linear_mps for a base of mecanum or omni wheels, else 0."""
    max_linear_acceleration_mps2: Annotated[float, Field(gt=0, le=100)] = 1.5
    """The highest acceleration, in metres a second, per second."""
    max_angular_acceleration_rps2: Annotated[float, Field(gt=0, le=200)] = 6.0
    """The highest acceleration of turning, in radians a second, per second."""
    braking_mps2: Annotated[float, Field(gt=0, le=100)] = 2.0
    """How hard the robot and its board brake, in metres a second, per second. Measure it with `wax
    prove-stop`; the speed allowed over a link depends on it."""
    soft_braking: bool = False
    """Whether the robot slows down at braking_mps2, instead of at once, when the operator lets go
    or their commands end: for a robot that would fall over. Stop, hand-over and faults still stop
    it at once."""
    silence_ms: Annotated[int, Field(ge=60, le=1000)] = 120
    """The driver process stops the robot after this many milliseconds without a message from the
    server. 120 is six periods at 50 Hz."""
    wheel_base_m: Annotated[float, Field(gt=0, le=5)] = 0.3
    """Metres between the wheels on the left and those on the right: measure them, since turns
    depend on it."""
    axle_base_m: Annotated[float, Field(gt=0, le=5)] = 0.3
    """Metres between the front and the rear axle of a mecanum base."""
    omni_radius_m: Annotated[float, Field(gt=0, le=5)] = 0.15
    """Metres from the middle of an omni base to each wheel."""
    width_m: Annotated[float, Field(ge=0, le=5)] = 0.0
    """The robot's width in metres, for the path that the page draws on the picture. 0 is not known:
    one line is drawn for its middle, except for the simulated robot, which knows itself."""
    left_trim: Annotated[float, Field(ge=0.1, le=1)] = 1.0
    """The fraction of its speed that the left motor gets, for a robot that drifts to the right. Of
    four wheels, both on that side get it."""
    right_trim: Annotated[float, Field(ge=0.1, le=1)] = 1.0
    """The fraction of its speed that the right motor gets, for a robot that drifts to the left."""
    invert_left: bool = False
    """Whether the left motor, or both on that side, is wired the other way round. Where only one of
    the two is, or an omni base's back one, swap its wires."""
    invert_right: bool = False
    """Whether the right motor, or both on that side, is wired the other way round."""
    serial: SerialSettings = SerialSettings()

    @property
    def lateral_mps(self) -> float:
        """The highest speed sideways, 0 for a robot that cannot move so."""
        if self.max_lateral_mps != "auto":
            return self.max_lateral_mps
        return 0.0 if self.base == "differential" else self.max_linear_mps

    @property
    def lever_m(self) -> float:
        """A wheel's speed in m/s for each rad/s on the spot."""
        return {
            "differential": self.wheel_base_m / 2.0,
            "mecanum": (self.wheel_base_m + self.axle_base_m) / 2.0,
            "omni": self.omni_radius_m,
        }[self.base]

    @model_validator(mode="after")
    def _has_the_wheels_of_its_lines(self) -> Self:
        if self.driver == "serial" and self.serial.dialect == "text":
            self.serial.text.check_wheels(self.base)
            is_unsaid = self.base == "differential" and self.max_lateral_mps == "auto"
            if is_unsaid and self.serial.text.moves_sideways:
                raise ValueError(
                    "max_lateral_mps is missing: serial.text.drive has {lateral}, so how fast does"
                    " the robot move sideways? 0 if it does not"
                )
        return self

    def own(self, model: type[OwnT]) -> OwnT:
        """Return a driver's own table, with defaults for missing keys."""
        return model.model_validate(self.own_tables.get(model.TABLE, {}))

    @property
    def own_tables(self) -> dict[str, dict[str, Any]]:
        """The drivers' own tables by name, as written."""
        return self.__pydantic_extra__ or {}
