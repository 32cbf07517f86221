"""`[robot.serial]`: the board on a serial line."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import BeforeValidator, Field, field_validator, model_validator

from wax.config.allowed import said
from wax.config.table import ConfigTable, Name, check_apart
from wax.config.text_dialect import TextDialectSettings

Byte = Annotated[int, Field(ge=0, le=255)]


OptionalByte = Annotated[
    Byte | None,
    BeforeValidator(lambda value: None if value == "none" else value),  # TOML has no null
    said('a whole number from 0 to 255, or "none" to send nothing'),
]


class BytesDialectSettings(ConfigTable):
    """The byte for each command of the dialect "bytes", as a number. The defaults are letters that
    many sketches for such boards use: F, B, L, R, G, I, H, J, S, 1, 2.
    """

    forward: Byte = ord("F")
    """Straight forward ("F")."""
    back: Byte = ord("B")
    """Straight back ("B")."""
    left: Byte = ord("L")
    """Turn left on the spot ("L")."""
    right: Byte = ord("R")
    """Turn right on the spot ("R")."""
    forward_left: Byte = ord("G")
    """Forward and left ("G")."""
    forward_right: Byte = ord("I")
    """Forward and right ("I")."""
    back_left: Byte = ord("H")
    """Back and left ("H")."""
    back_right: Byte = ord("J")
    """Back and right ("J")."""
    stop: Byte = ord("S")
    """Stop ("S")."""
    fine: OptionalByte = ord("1")
    """Sent before a command when the speed has changed to fine ("1")."""
    gross: OptionalByte = ord("2")
    """Sent before a command when the speed has changed to gross ("2")."""


class SerialSettings(ConfigTable):
    """A board on a serial line, only for driver = "serial"."""

    url: Annotated[str, Field(min_length=1)] = "/dev/ttyACM0"
    """The port, as listed by `wax devices` (a link in /dev/serial stays the same when others are
    plugged in, a number may not), or any URL that pyserial opens ("socket://host:port",
    "rfc2217://host:port")."""
    baud: Annotated[int, Field(ge=300, le=4_000_000)] = 115_200
    """Bits a second; it must match the board's program. The frames take 1.1 kB a second, so they
    need at least 19 200."""
    dialect: Literal["frames", "bytes", "text"] = "frames"
    """How the board is spoken to. "frames" are for the program in server/firmware, which stops by
    itself when it hears nothing: they have a checksum, a number and a time-to-live
    (server/wax/robot/serial/frames.py describes them byte by byte). "bytes" is one byte a command,
    sent on change, for existing boards; "text" are lines that you describe, for sketches and motor
    controllers that understand such."""
    axes: Annotated[list[Name], Field(max_length=4)] = []
    """What the board can move besides its wheels, such as ["pan", "tilt"]; the place in this list,
    from 0, is the number in the frame "axis". Positions go from -1 to 1; the board knows its
    range. Not for "bytes"; the page shows a slider for each."""
    ttl_ms: Annotated[int, Field(ge=20, le=1000)] = 200
    """Milliseconds without a newer frame after which the board stops itself. 200 is ten periods of
    the control loop: long enough for a busy machine, short enough for a dead one."""
    reopen_s: Annotated[float, Field(ge=0.05, le=60)] = 0.5
    """Seconds between attempts to open a lost port."""
    ticks_per_m: Annotated[float, Field(ge=0, le=1e6)] = 0.0
    """How many ticks each of the board's encoders counts in a metre straight ahead; push the robot
    along some metres of tape measure to find out. Its speed and its place are then known, unless
    the frames move it sideways. 0: not measured."""
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
