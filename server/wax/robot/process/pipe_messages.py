"""What the server and the driver's process say to each other: one JSON object a line.

``sent_s`` is the server's monotonic clock, which is one and the same in both processes of a
machine. NaN and infinity are let through in a twist only, where they mean standstill.
"""

from __future__ import annotations

from typing import Annotated, Final, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from wax.config.settings import LogSettings, RobotSettings
from wax.driver.checks import checked
from wax.driver.interface import Limits, RobotState
from wax.errors import ProtocolError

MAX_LINE_BYTES: Final = 32_768

Number = Annotated[int, Field(ge=0, le=2**63)]
Seconds = Annotated[float, Field(allow_inf_nan=False)]


class _Said(BaseModel):
    model_config = ConfigDict(
        extra="forbid", strict=True, frozen=True, ser_json_inf_nan="constants"
    )


class Begin(_Said):
    """Server → process, first of all: which robot, and how to write the log."""

    say: Literal["begin"] = "begin"
    robot: RobotSettings
    log: LogSettings


class _Command(_Said):
    sequence: Number
    sent_s: Seconds
    turn: Number


class Move(_Command):
    """Server → process: a set-point."""

    say: Literal["move"] = "move"
    linear_mps: float
    angular_rps: float


class Axis(_Command):
    """Server → process: where an auxiliary axis shall be, in -1…1."""

    say: Literal["axis"] = "axis"
    name: str
    position: Annotated[float, Field(ge=-1, le=1)]


class Halt(_Command):
    """Server → process: stand still now."""

    say: Literal["halt"] = "halt"


class Ready(_Said):
    """Process → server, first of all: the driver is built, and this is what it is."""

    say: Literal["ready"] = "ready"
    kind: str
    limits: Limits


class Told(_Said):
    """Process → server: how the robot is, and what was counted since the process began."""

    say: Literal["told"] = "told"
    state: RobotState
    counts: dict[str, int]


Message = Move | Axis | Halt
_MESSAGE: Final[TypeAdapter[Message]] = TypeAdapter(Annotated[Message, Field(discriminator="say")])
_ANSWER: Final[TypeAdapter[Ready | Told]] = TypeAdapter(
    Annotated[Ready | Told, Field(discriminator="say")]
)
_BEGIN: Final = TypeAdapter(Begin)
_T = TypeVar("_T")


def encode(said: _Said) -> bytes:
    """Write a line, with its end."""
    return said.model_dump_json().encode() + b"\n"


def decode_begin(line: bytes) -> Begin:
    """Read the first line of the server; raises `ProtocolError`."""
    return _decode(_BEGIN, line)


def decode_message(line: bytes) -> Message:
    """Read a later line of the server; raises `ProtocolError`."""
    return _decode(_MESSAGE, line)


def decode_answer(line: bytes) -> Ready | Told:
    """Read a line of the process; raises `ProtocolError`."""
    return _decode(_ANSWER, line)


def tellable(state: object) -> RobotState:
    """Refuse what somebody's driver may return instead of a state.

    Raises `TypeError`, or `ValueError` where it cannot be told to the server.
    """
    told = Told(state=checked(state), counts={}).model_dump_json(warnings=False)
    return Told.model_validate_json(told).state


def _decode(adapter: TypeAdapter[_T], line: bytes) -> _T:
    if len(line) > MAX_LINE_BYTES:
        raise ProtocolError("a line is too long")
    try:
        return adapter.validate_json(line)
    except ValidationError as error:
        raise ProtocolError(f"a line is none of ours: {error.errors()[0]['msg']}") from error


class LineBuffer:
    """Cuts what comes through a pipe into lines; what never ends is kept no longer than it may."""

    def __init__(self) -> None:
        self._rest = b""

    def feed(self, data: bytes) -> list[bytes]:
        """Take bytes and give the lines that they end, without their ends."""
        *lines, rest = (self._rest + data).split(b"\n")
        self._rest = rest[: MAX_LINE_BYTES + 1]  # one too many, so that it is refused at its end
        return lines
