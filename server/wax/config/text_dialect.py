"""`[robot.serial.text]`: the lines of text of the host's own sketch or motor controller."""

from __future__ import annotations

from typing import Annotated, Final, Self

from pydantic import Field, field_validator, model_validator

from wax.config.line_template import ANY, MAX_CHARS, LineTemplate
from wax.config.table import ConfigTable

WHEELS: Final = ("left", "right")
TWIST: Final = ("linear", "angular")
POSITION: Final = "position"
TICKS: Final = ("left_ticks", "right_ticks")
REPORTED: Final = (
    "battery_v",
    "battery_dv",
    "battery_mv",
    "bumpers",
    "moving",
    *WHEELS,
    *TICKS,
    ANY,
)
"""The fields of a line from the robot; ``_dv`` is tenths of a volt."""

Line = Annotated[str, Field(max_length=MAX_CHARS, description="a line in double quotes, or empty")]
OneLine = Annotated[
    str,
    Field(
        min_length=1,
        description="a line in double quotes",
        json_schema_extra={"plural": "lines"},
    ),
]
Lines = list[OneLine]


class TextAxisSettings(ConfigTable):
    """One of `axis`: the line of the axis with the same index in `[robot.serial] axes`."""

    line: OneLine
    least: Annotated[float, Field(ge=-1e6, le=1e6)] = -1.0
    most: Annotated[float, Field(ge=-1e6, le=1e6)] = 1.0

    @field_validator("line")
    @classmethod
    def _has_its_place(cls, line: str) -> str:
        if POSITION not in LineTemplate(line, (POSITION,)).names:
            raise ValueError(f"has no {{{POSITION}}}; without it the axis cannot move")
        return line


class TextDialectSettings(ConfigTable):
    """The text dialect; with another dialect, `drive` may stay empty."""

    drive: Line = ""
    stop: Line = ""
    per_mps: Annotated[float, Field(ge=0, le=1e6)] = 0.0
    per_rps: Annotated[float, Field(ge=0, le=1e6)] = 0.0
    limit: Annotated[float, Field(ge=0, le=1e6)] = 0.0
    ttl_ms: Annotated[int, Field(ge=0, le=10_000)] = 0
    keep_alive_ms: Annotated[int, Field(ge=20, le=1000)] = 100
    boot_ms: Annotated[int, Field(ge=0, le=10_000)] = 2000
    begin: Annotated[Lines, Field(max_length=8)] = []
    end: Annotated[Lines, Field(max_length=4)] = []
    answers: Line = ""
    answer_ms: Annotated[int, Field(ge=100, le=1000)] = 500
    ask: Annotated[Lines, Field(max_length=4)] = []
    ask_ms: Annotated[int, Field(ge=50, le=10_000)] = 200
    reports: Annotated[Lines, Field(max_length=8)] = []
    axis: Annotated[list[TextAxisSettings], Field(max_length=4)] = []

    @field_validator("drive")
    @classmethod
    def _drives(cls, line: str) -> str:
        names = set(LineTemplate(line, (*WHEELS, *TWIST)).names)
        pairs = [pair for pair in (WHEELS, TWIST) if names & set(pair)]
        if line and not pairs:
            raise ValueError(
                f"{line!r} has no place for a speed; write {{left}} and {{right}} for the wheels,"
                " or {linear} and {angular}"
            )
        missing = next((name for pair in pairs for name in pair if name not in names), None)
        if missing is not None:
            raise ValueError(f"{line!r} has no {{{missing}}}; without it the robot cannot steer")
        return line

    @field_validator("stop", "answers")
    @classmethod
    def _has_no_places(cls, line: str) -> str:
        LineTemplate(line, ())
        return line

    @field_validator("begin", "end", "ask")
    @classmethod
    def _have_no_places(cls, lines: list[str]) -> list[str]:
        for line in lines:
            LineTemplate(line, ())
        return lines

    @field_validator("reports")
    @classmethod
    def _tell_something(cls, lines: list[str]) -> list[str]:
        for line in lines:
            names = set(LineTemplate(line, REPORTED).names) - {ANY}
            if not names:
                raise ValueError(f"{line!r} tells nothing; name what its numbers are")
            if len(names & set(TICKS)) == 1:
                raise ValueError(
                    f"{line!r} tells the ticks of one wheel; those of both must be in one line,"
                    " as of one moment"
                )
        return lines

    @model_validator(mode="after")
    def _is_to_scale(self) -> Self:
        names = LineTemplate(self.drive, (*WHEELS, *TWIST)).names
        if self.per_mps == 0.0 and names:
            raise ValueError(
                "per_mps is missing: what number does the line say for 1 m/s? 1000 for mm/s, 1 for"
                " m/s, or measure it"
            )
        if self.per_rps == 0.0 and "angular" in names:
            raise ValueError(
                "per_rps is missing: what number does the line say for 1 rad/s? 1 for rad/s, 57.3"
                " for degrees a second, or measure it"
            )
        return self

    @model_validator(mode="after")
    def _is_said_in_time(self) -> Self:
        if 0 < self.ttl_ms < 2 * self.keep_alive_ms:
            raise ValueError(
                f"keep_alive_ms is {self.keep_alive_ms} and ttl_ms {self.ttl_ms}; say the line at"
                " least twice as often, or the robot stutters"
            )
        if self.answers and self.answer_ms < 2 * self.keep_alive_ms:
            raise ValueError(
                f"keep_alive_ms is {self.keep_alive_ms} and answer_ms {self.answer_ms}; an answer"
                " must have the time of two lines at least"
            )
        return self
