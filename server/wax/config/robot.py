"""`[robot]`: its driver, its limits and its wheels."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from pydantic import ConfigDict, Field

from wax.config.serial import SerialSettings
from wax.config.table import ConfigTable

if TYPE_CHECKING:
    from wax.config.driver_settings import DriverSettings


OwnT = TypeVar("OwnT", bound="DriverSettings")


class RobotSettings(ConfigTable):
    """`[robot]`: our keys, and drivers' own tables (`DriverSettings`)."""

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, dict[str, Any]] = Field(init=False)

    driver: Annotated[str, Field(min_length=1)] = "simulated"
    max_linear_mps: Annotated[float, Field(gt=0, le=10)] = 0.6
    max_angular_rps: Annotated[float, Field(gt=0, le=20)] = 1.5
    max_linear_acceleration_mps2: Annotated[float, Field(gt=0, le=100)] = 1.5
    max_angular_acceleration_rps2: Annotated[float, Field(gt=0, le=200)] = 6.0
    braking_mps2: Annotated[float, Field(gt=0, le=100)] = 2.0
    soft_braking: bool = False
    silence_ms: Annotated[int, Field(ge=60, le=1000)] = 120
    wheel_base_m: Annotated[float, Field(gt=0, le=5)] = 0.3
    width_m: Annotated[float, Field(ge=0, le=5)] = 0.0
    left_trim: Annotated[float, Field(ge=0.1, le=1)] = 1.0
    right_trim: Annotated[float, Field(ge=0.1, le=1)] = 1.0
    invert_left: bool = False
    invert_right: bool = False
    serial: SerialSettings = SerialSettings()

    def own(self, model: type[OwnT]) -> OwnT:
        """Return a driver's own table, with defaults for missing keys."""
        return model.model_validate(self.own_tables.get(model.TABLE, {}))

    @property
    def own_tables(self) -> dict[str, dict[str, Any]]:
        """The drivers' own tables by name, as written."""
        return self.__pydantic_extra__ or {}
