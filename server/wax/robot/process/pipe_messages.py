"""The messages between the server and the driver process: one JSON object a line.

``sent_s`` is on the monotonic clock, which all processes of a machine share. NaN and infinity are
allowed only in a twist, where they mean standstill.
"""

from __future__ import annotations

from typing import Annotated, Final, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from wax.config.controls import ControlSettings
from wax.config.local import LocalSettings
from wax.config.log import LogSettings
from wax.config.robot import RobotSettings
from wax.driver.checks import checked
from wax.driver.interface import ControlValue, Limits, RobotState
from wax.errors import ProtocolError

MAX_LINE_BYTES: Final = 32_768

Number = Annotated[int, Field(ge=0, le=2**63)]
Seconds = Annotated[float, Field(allow_inf_nan=False)]


class _PipeMessage(BaseModel):
    model_config = ConfigDict(
        extra="forbid", strict=True, frozen=True, ser_json_inf_nan="constants"
    )


class Begin(_PipeMessage):
    """Server → process, the first line: which robot, how to write the log, and who is aboard.

    `controls` says which of the robot's controls move, and which work only while held.

    `claim` is the file by which one process takes the robot over from another (`passenger_claim`).
    """

    say: Literal["begin"] = "begin"
    robot: RobotSettings
    log: LogSettings
    local: LocalSettings = LocalSettings()
    claim: str = ""
    controls: list[ControlSettings] = []


class _Command(_PipeMessage):
    sequence: Number
    sent_s: Seconds
    turn: Number


class Move(_Command):
    """Server → process: a set-point, and whether an operator is there who may drive.

    `end_s` is when the server must stop the robot unless a newer command arrives, None if no
    command moves it.
    """

    say: Literal["move"] = "move"
    linear_mps: float
    angular_rps: float
    lateral_mps: float = 0.0
    operated: bool = True
    end_s: Seconds | None = None


class Axis(_Command):
    """Server → process: the position of an auxiliary axis, in -1…1."""

    say: Literal["axis"] = "axis"
    name: str
    position: Annotated[float, Field(ge=-1, le=1)]


class Control(_Command):
    """Server → process: the new value of a control, see `HasControls.control`."""

    say: Literal["control"] = "control"
    name: str
    value: ControlValue


class Halt(_Command):
    """Server → process: stop now."""

    say: Literal["halt"] = "halt"


class Bye(_PipeMessage):
    """Server → process, the last line if a person is aboard: the process must end, too.

    Without it the end of the pipe means that the server has died, and the person drives on.
    """

    say: Literal["bye"] = "bye"


class Ready(_PipeMessage):
    """Process → server, the first line: the driver is built, with this kind and these limits."""

    say: Literal["ready"] = "ready"
    kind: str
    limits: Limits


class NotBuilt(_PipeMessage):
    """Process → server, instead of `Ready`: the driver cannot be built, and the process ends."""

    say: Literal["not built"] = "not built"
    why: str


class StateReport(_PipeMessage):
    """Process → server: the robot's state, and the counts since the process began."""

    say: Literal["told"] = "told"
    state: RobotState
    counts: dict[str, int]


Message = Move | Axis | Control | Halt
_MESSAGE: Final[TypeAdapter[Message | Bye]] = TypeAdapter(
    Annotated[Message | Bye, Field(discriminator="say")]
)
Report = Ready | NotBuilt | StateReport
_ANSWER: Final[TypeAdapter[Report]] = TypeAdapter(Annotated[Report, Field(discriminator="say")])
_BEGIN: Final = TypeAdapter(Begin)
_T = TypeVar("_T")


def encode(said: _PipeMessage) -> bytes:
    """Return the message as a line, newline included."""
    return said.model_dump_json().encode() + b"\n"


def decode_begin(line: bytes) -> Begin:
    """Read the first line of the server; raises `ProtocolError`."""
    return _decode(_BEGIN, line)


def decode_message(line: bytes) -> Message | Bye:
    """Read a later line of the server; raises `ProtocolError`."""
    return _decode(_MESSAGE, line)


def decode_answer(line: bytes) -> Report:
    """Read a line of the process; raises `ProtocolError`."""
    return _decode(_ANSWER, line)


def sendable(state: object) -> RobotState:
    """Return a driver's state if it is valid and survives the pipe.

    Raises `TypeError` if it is not a state, `ValueError` if it cannot be sent to the server.
    """
    told = StateReport(state=checked(state), counts={}).model_dump_json(warnings=False)
    return StateReport.model_validate_json(told).state


def _decode(adapter: TypeAdapter[_T], line: bytes) -> _T:
    if len(line) > MAX_LINE_BYTES:
        raise ProtocolError("invalid message: the line is too long")
    try:
        return adapter.validate_json(line)
    except ValidationError as error:
        raise ProtocolError(f"invalid message: {error.errors()[0]['msg']}") from error


class LineBuffer:
    """Splits a pipe's bytes into lines; keeps at most `MAX_LINE_BYTES` of an unfinished one."""

    def __init__(self) -> None:
        self._rest = b""

    def feed(self, data: bytes) -> list[bytes]:
        """Add bytes and return the lines they complete, without newlines."""
        *lines, rest = (self._rest + data).split(b"\n")
        self._rest = rest[: MAX_LINE_BYTES + 1]  # one byte too many, so that the line is refused
        return lines
