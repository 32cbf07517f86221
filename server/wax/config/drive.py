"""`[drive]`: how commands become motion."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from wax.config.table import ConfigTable


class DriveSettings(ConfigTable):
    """`[drive]`: how commands become motion."""

    command_rate_hz: Annotated[float, Field(ge=20, le=50)] = 50.0
    loop_hz: Annotated[float, Field(ge=20, le=100)] = 50.0
    max_age_ms: Annotated[float, Field(ge=50, le=1000)] = 150.0
    max_command_age_ms: Annotated[float, Field(ge=50, le=2000)] = 500.0
    slow_picture_age_ms: Annotated[float, Field(ge=100, le=60_000)] = 400.0
    stop_picture_age_ms: Annotated[float, Field(ge=100, le=60_000)] = 800.0
    max_stop_distance_m: Annotated[float, Field(gt=0, le=10)] = 0.3
    slow_fraction: Annotated[float, Field(gt=0, le=1)] = 0.3
    click_to_move: bool = False

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if self.max_command_age_ms < self.max_age_ms:
            raise ValueError(
                f"max_command_age_ms is {self.max_command_age_ms:g} and max_age_ms"
                f" {self.max_age_ms:g}; max_command_age_ms must be the larger one"
            )
        if self.stop_picture_age_ms < self.slow_picture_age_ms:
            raise ValueError(
                f"stop_picture_age_ms is {self.stop_picture_age_ms:g} and slow_picture_age_ms"
                f" {self.slow_picture_age_ms:g}; stop_picture_age_ms must be the larger one"
            )
        return self
