"""The messages between the server and the media process.

The first line on the pipe is `MediaBegin`; then the process sends empty lines as heartbeats, and
ends when the pipe ends. Each sense has a connection of its own, on which the server asks and the
process answers: a line of JSON, and data after it. Pictures are passed in shared memory instead.
"""

from __future__ import annotations

from typing import Annotated, Any, Final, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from wax.config.log import LogSettings
from wax.config.robot import RobotSettings
from wax.errors import ProtocolError
from wax.sentence import Sentence

Sense = Literal["camera", "external_view", "microphone", "speaker"]

NEXT: Final = b"next"
"""Asks a camera or microphone for its next picture or sound."""
NEWEST: Final = b"newest"
"""Asks a microphone for its next sound, and to drop what is queued."""
OPEN: Final = b"open"
WRITE: Final = b"write"
CLOSE: Final = b"close"
"""Requests to a speaker; the samples follow `WRITE`."""

MAX_HEAD_BYTES: Final = 8192
MAX_SAMPLES: Final = 48_000
MAX_ANSWER_BYTES: Final = MAX_HEAD_BYTES + 2 * 2 * MAX_SAMPLES
MAX_WIDTH: Final = 3840
MAX_HEIGHT: Final = 2160


class _Message(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)


class Outlet(_Message):
    """One sense: its connection's descriptor, and for a camera its memory's and its settings."""

    sense: Sense
    connection: int
    memory: int | None = None
    video: dict[str, Any] | None = None


class MediaBegin(_Message):
    """Server → process, the first line: which robot, and which of its senses are wanted."""

    robot: RobotSettings
    log: LogSettings
    outlets: list[Outlet]


class Answer(_Message):
    """Process → server: the result of a request, or why there is none.

    `within_s`, `width` and `height` describe the picture in memory, `channels` the sound that
    follows.
    """

    problem: Sentence | None = None
    captured_s: float = 0.0
    within_s: Annotated[float, Field(ge=0)] | None = None
    width: Annotated[int, Field(ge=0, le=MAX_WIDTH, multiple_of=2)] = 0
    height: Annotated[int, Field(ge=0, le=MAX_HEIGHT, multiple_of=2)] = 0
    channels: Annotated[int, Field(ge=1, le=2)] = 1


def encode(answer: Answer, payload: bytes = b"") -> bytes:
    """Encode an answer for sending."""
    return answer.model_dump_json(exclude_defaults=True).encode() + b"\n" + payload


def decode(data: bytes) -> tuple[Answer, bytes]:
    """Decode an answer and the data after it; raises `ProtocolError`."""
    head, _, payload = data.partition(b"\n")
    try:
        return Answer.model_validate_json(head), payload
    except ValidationError as error:
        raise ProtocolError(f"invalid answer: {error.errors()[0]['msg']}") from error
