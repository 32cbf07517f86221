"""`[robot.serial.text]`: the lines of text of the host's own sketch or motor controller."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Final, Self

from pydantic import Field, field_validator, model_validator

from wax.config.allowed import said
from wax.config.bases import WHEELS, WHEELS_OF
from wax.config.line_template import ANY, MAX_CHARS, LineTemplate
from wax.config.table import ConfigTable

if TYPE_CHECKING:
    from collections.abc import Collection

    from wax.config.bases import Base

TWIST: Final = ("linear", "angular")
LATERAL: Final = "lateral"
DRIVEN: Final = (*WHEELS, *TWIST, LATERAL)
"""The fields of the line that drives the robot."""
POSITION: Final = "position"
TICKS: Final = {f"{wheel}_ticks": wheel for wheel in WHEELS}
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

Line = Annotated[str, Field(max_length=MAX_CHARS), said("a line in double quotes, or empty")]
OneLine = Annotated[
    str,
    Field(min_length=1),
    said("a line in double quotes", plural="lines"),
]
Lines = list[OneLine]


class TextAxisSettings(ConfigTable):
    """One of `axis`: the line of the axis with the same index in `[robot.serial] axes`."""

    line: OneLine
    """The line that moves it, with {position}."""
    least: Annotated[float, Field(ge=-1e6, le=1e6)] = -1.0
    """The number for its position -1."""
    most: Annotated[float, Field(ge=-1e6, le=1e6)] = 1.0
    """The number for its position 1."""

    @field_validator("line")
    @classmethod
    def _has_its_place(cls, line: str) -> str:
        if POSITION not in LineTemplate(line, (POSITION,)).names:
            raise ValueError(f"has no {{{POSITION}}}; without it the axis cannot move")
        return line


class TextDialectSettings(ConfigTable):
    r"""The lines of the dialect "text". A line is text in double quotes, "\r" and "\n" its end as
    the board wants it. {left} and {right} are the wheels' speeds, {linear} and {angular} the
    robot's; {left} is a whole number, {left:.2f} has two decimals. The wheels of a mecanum base are
    {front_left}, {front_right}, {back_left} and {back_right}, those of an omni base {left}, {right}
    and {back}, which is positive where it drives to the left; for a board that mixes by itself,
    {lateral} is the speed to the left. ros-arduino-bridge.toml and roboteq.toml are examples.
    """

    drive: Line = ""
    r"""The line that drives the robot, such as "m {left} {right}\r"; the dialect "text" needs
    it."""
    stop: Line = ""
    """The line that stops the robot, where that is not drive with zeros. It is sent again and
    again; the next drive must start the robot again without anything between."""
    per_mps: Annotated[float, Field(ge=0, le=1e6)] = 0.0
    """The number in the line is the speed in metres a second times this: 1 for m/s, 1000 for mm/s;
    for encoder ticks a loop, the ticks of a metre divided by the loops of a second; for shares of
    full power, the largest share divided by the speed that you measure with it."""
    per_rps: Annotated[float, Field(ge=0, le=1e6)] = 0.0
    """The same for turning, where the line has {angular}: 1 for radians a second, 57.3 for
    degrees."""
    limit: Annotated[float, Field(ge=0, le=1e6)] = 0.0
    """The largest number that the line may have, such as 255 or 1000; all are reduced together, so
    that a curve stays the same. 0: there is no limit."""
    ttl_ms: Annotated[int, Field(ge=0, le=10_000)] = 0
    """Milliseconds without a line after which the board stops by itself: look for a timeout in its
    program. 0: it does not, or you do not know. Then a pulled cable leaves it moving, and WAX
    warns."""
    keep_alive_ms: Annotated[int, Field(ge=20, le=1000)] = 100
    """Milliseconds after which the newest line is sent again, also while the robot stands. A change
    is sent at once."""
    boot_ms: Annotated[int, Field(ge=0, le=10_000)] = 2000
    """Milliseconds from the opening of the port until the board listens. Most Arduinos restart
    then."""
    begin: Annotated[Lines, Field(max_length=8)] = []
    """Lines sent once the board listens, such as settings. The robot is told to stop before and
    after."""
    end: Annotated[Lines, Field(max_length=4)] = []
    r"""Lines sent at the end, after the last stop, such as "!EX\r"."""
    answers: Line = ""
    """What the board answers to a line, such as "OK"; then the robot counts as connected only while
    the board does. Leave it empty where it answers nothing."""
    answer_ms: Annotated[int, Field(ge=100, le=1000)] = 500
    """Milliseconds without such an answer after which the robot counts as lost; then let go of all
    controls to drive on."""
    ask: Annotated[Lines, Field(max_length=4)] = []
    """Lines that ask the board for what reports describes, one after the other."""
    ask_ms: Annotated[int, Field(ge=50, le=10_000)] = 200
    """Milliseconds from one line of ask to the next."""
    reports: Annotated[Lines, Field(max_length=8)] = []
    """What the board tells, such as "V={battery_v}" or "{left_ticks} {right_ticks}". It may name
    {battery_v}, {battery_dv} (tenths of a volt), {battery_mv}, {bumpers} (a bit each), {moving}
    (0 if not), {left} and {right} (speeds in any unit), {left_ticks} and {right_ticks}, and {_}
    for a number of no interest; of another base, its own wheels."""
    axis: Annotated[list[TextAxisSettings], Field(max_length=4)] = []
    r"""The lines of [robot.serial] axes, one table for each and in their order, such as
    [[robot.serial.text.axis]] with line = "s 9 {position}\r"."""

    @field_validator("drive")
    @classmethod
    def _drives(cls, line: str) -> str:
        names = set(LineTemplate(line, DRIVEN).names)
        if line and not names:
            raise ValueError(
                f"{line!r} has no place for a speed; write {{left}} and {{right}} for the wheels,"
                " or {linear} and {angular}"
            )
        missing = _missing(names & set(WHEELS))
        if missing is None and not names.isdisjoint({*TWIST, LATERAL}):
            missing = next((name for name in TWIST if name not in names), None)
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
            missing = _missing({TICKS[name] for name in names & set(TICKS)})
            if missing is not None:
                raise ValueError(
                    f"{line!r} has no {{{missing}_ticks}}; the ticks of all wheels must be in one"
                    " line, as of one moment"
                )
        return lines

    @model_validator(mode="after")
    def _is_to_scale(self) -> Self:
        names = LineTemplate(self.drive, DRIVEN).names
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

    @property
    def moves_sideways(self) -> bool:
        """Whether the line that drives it has {lateral}, or wheels that differential bases lack."""
        rest = {*WHEELS, LATERAL} - set(WHEELS_OF["differential"])
        return not rest.isdisjoint(LineTemplate(self.drive, DRIVEN).names)

    def check_wheels(self, base: Base) -> None:
        """Raise `ValueError` for a line with wheels of another base."""
        drives = LineTemplate(self.drive, DRIVEN).names
        told = [name for line in self.reports for name in LineTemplate(line, REPORTED).names]
        for key, wheels in (
            ("drive", {name for name in drives if name in WHEELS}),
            ("reports", {TICKS[name] for name in told if name in TICKS}),
        ):
            if wheels and wheels != set(WHEELS_OF[base]):
                raise ValueError(
                    f'serial.text.{key} has the wheels {_listed(wheels)}, but base = "{base}" has'
                    f" {_listed(WHEELS_OF[base])}; write those, or another base"
                )


def _missing(wheels: set[str]) -> str | None:
    """Return the first wheel that these lack to be all of a base; None if there are none at all.

    Raises `ValueError` for wheels of different bases.
    """
    bases = [names for names in WHEELS_OF.values() if wheels <= set(names)]
    if not bases:
        raise ValueError(f"no base has the wheels {_listed(wheels)}")
    return next((name for name in bases[0] if name not in wheels), None) if wheels else None


def _listed(wheels: Collection[str]) -> str:
    return ", ".join(name for name in WHEELS if name in wheels)
