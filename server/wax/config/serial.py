"""`[robot.serial]`: the board on a serial line."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import BeforeValidator, Field, field_validator, model_validator

from wax.config.table import ConfigTable, Name, check_apart
from wax.config.text_dialect import TextDialectSettings

Byte = Annotated[int, Field(ge=0, le=255)]


OptionalByte = Annotated[
    Byte | None,
    BeforeValidator(lambda value: None if value == "none" else value),  # TOML has no null
    Field(description='a whole number from 0 to 255, or "none" to send nothing'),
]


class BytesDialectSettings(ConfigTable):
    """`[robot.serial.bytes]`: the thesis's protocol, with the one byte of each command."""

    forward: Byte = ord("F")
    back: Byte = ord("B")
    left: Byte = ord("L")
    right: Byte = ord("R")
    forward_left: Byte = ord("G")
    forward_right: Byte = ord("I")
    back_left: Byte = ord("H")
    back_right: Byte = ord("J")
    stop: Byte = ord("S")
    fine: OptionalByte = ord("1")
    gross: OptionalByte = ord("2")


class SerialSettings(ConfigTable):
    """`[robot.serial]`."""

    url: Annotated[str, Field(min_length=1)] = "/dev/ttyACM0"
    baud: Annotated[int, Field(ge=300, le=4_000_000)] = 115_200
    dialect: Literal["frames", "bytes", "text"] = "frames"
    axes: Annotated[list[Name], Field(max_length=4)] = []
    ttl_ms: Annotated[int, Field(ge=20, le=1000)] = 200
    reopen_s: Annotated[float, Field(ge=0.05, le=60)] = 0.5
    ticks_per_m: Annotated[float, Field(ge=0, le=1e6)] = 0.0
    bytes: BytesDialectSettings = BytesDialectSettings()
    text: TextDialectSettings = TextDialectSettings()

    @field_validator("axes")
    @classmethod
    def _axes_differ(cls, axes: list[str]) -> list[str]:
        check_apart("two axes have the name {}; give each its own", axes)
        return axes

    @model_validator(mode="after")
    def _has_its_lines(self) -> Self:
        if self.dialect != "text":
            return self
        if not self.text.drive:
            raise ValueError(
                "text.drive is missing: it is the line by which your sketch or controller drives,"
                r' such as "m {left} {right}\r"'
            )
        if len(self.axes) != len(self.text.axis):
            raise ValueError(
                f"axes has {len(self.axes)} names and text.axis {len(self.text.axis)} lines; each"
                " axis needs its own"
            )
        return self
