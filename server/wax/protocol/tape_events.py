"""The events on the tape beside picture and sound: one model for each topic of its MCAP files.

The page of `wax replay` reads the same models. Viewers are numbers, as in the room. A field is null
if unknown; times within an event are ages in milliseconds at the event's own time, so that reading
them needs no second clock.
"""

from __future__ import annotations

from operator import not_
from typing import TYPE_CHECKING, Annotated, Final, Literal, get_args

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from wax.errors import ProtocolError
from wax.protocol.robot_report import RobotReport

if TYPE_CHECKING:
    from collections.abc import Sequence

FORMAT: Final = 1
"""The version of the format. Any change raises it, except a new field with a default, or a new kind
of event, which older versions skip."""


class _Event(BaseModel):
    model_config = ConfigDict(frozen=True, allow_inf_nan=False)


class Commanded(_Event):
    """A command as received; `refused` is why the gate refused it, null if it was valid.

    `age_ms` is its age by its sender's clock, `seen_age_ms` that of the picture that the sender
    saw. `linear`, `angular` and `lateral` are fractions of the robot's limits; `lateral` is absent
    where it is 0.
    """

    type: Literal["commanded"] = "commanded"
    viewer: int
    seq: int
    turn: int
    age_ms: float
    seen_age_ms: float | None
    linear: float
    angular: float
    held: bool
    speed: Literal["slow", "fast"]
    axes: dict[str, float]
    refused: str | None
    lateral: Annotated[float, Field(exclude_if=not_)] = 0.0


class Steered(_Event):
    """A set-point sent to the robot, and the gate's (`wanted_…`), which the ramp approaches.

    It lasts until the next. Speeds sideways are absent where they are 0. `reason` is why the robot
    is held, `limit` why it is slower than asked. `axes` are the positions that the gate let through
    last, absent before the first. `controls` are those that are held or were set, absent without
    any: 1 for a button or toggle that is on, a slider's value, the number of a choice from 0.
    """

    type: Literal["steered"] = "steered"
    turn: int
    linear_mps: float
    angular_rps: float
    wanted_linear_mps: float
    wanted_angular_rps: float
    reason: str | None
    limit: str | None
    lateral_mps: Annotated[float, Field(exclude_if=not_)] = 0.0
    wanted_lateral_mps: Annotated[float, Field(exclude_if=not_)] = 0.0
    axes: Annotated[dict[str, float], Field(exclude_if=not_)] = {}
    controls: Annotated[dict[str, float], Field(exclude_if=not_)] = {}


class Reported(RobotReport, _Event):
    """The state that the robot reported; `gauges` is absent if it has none besides the others."""

    type: Literal["reported"] = "reported"
    connected: bool
    problem: str | None
    moving: bool | None
    x_m: float | None
    y_m: float | None
    heading_rad: float | None
    gauges: Annotated[dict[str, float], Field(exclude_if=not_)] = {}


class Turned(_Event):
    """A new turn; `operator` is null if nobody has it. `why` is how the previous turn ended."""

    type: Literal["turned"] = "turned"
    number: int
    operator: int | None
    why: str | None


class Stopped(_Event):
    """Somebody pressed Stop, or the stop with this number was released.

    `viewer` is null for somebody without a page.
    """

    type: Literal["stopped"] = "stopped"
    number: int
    pressed: bool
    viewer: int | None
    by_host: bool


class Faulted(_Event):
    """The robot was stopped while its operator drove, without anybody having pressed Stop."""

    type: Literal["faulted"] = "faulted"
    operator: int
    why: str


class Watched(_Event):
    """A viewer's measurements, once a second, and what they were sent.

    The ages are from capture to their screen and ear; `picture_held_ms` and `sound_held_ms` are the
    parts of them in the browser's buffers. `link_bps` is the estimate of their link, `why` the
    reason for what they are sent.
    """

    type: Literal["watched"] = "watched"
    viewer: int
    drives: bool
    round_trip_ms: float | None
    picture_ms: float | None
    picture_held_ms: float | None
    sound_ms: float | None
    sound_held_ms: float | None
    rendition: str | None
    picture_hz: float | None
    sound_mu_ms: int | None
    link_bps: int | None
    queue_ms: float | None
    why: str | None


class Named(_Event):
    """A viewer's name; only if names are recorded."""

    type: Literal["named"] = "named"
    viewer: int
    name: str


class Filmed(_Event):
    """The recording of another camera than the driving view begins: time 0 of its media file.

    `camera` is the number in that file's name, `name` is for people.
    """

    type: Literal["filmed"] = "filmed"
    camera: int
    name: str


class Missed(_Event):
    """Nothing was recorded for the `missed_s` before this, since the disk was too slow."""

    type: Literal["missed"] = "missed"
    missed_s: float


class Tasked(_Event):
    """What the operator said that they do in this turn; a later one replaces it, "" withdraws it.

    `turn` is the newest turn of that number, since turns count from 1 after each start.
    """

    type: Literal["tasked"] = "tasked"
    turn: int
    text: str


TapeEvent = (
    Commanded
    | Steered
    | Reported
    | Turned
    | Stopped
    | Faulted
    | Watched
    | Named
    | Filmed
    | Missed
    | Tasked
)
EVENTS: Final[Sequence[type[TapeEvent]]] = get_args(TapeEvent)


class Placed(_Event):
    """An event and its time, in ms since the beginning of its part of the tape."""

    at_ms: float
    event: Annotated[TapeEvent, Field(discriminator="type")]


class TapePart(_Event):
    """One part of the tape in the page's list; `kept` says at whose request or why it is kept.

    `began_wall_ms` is since 1970.
    """

    name: str
    began_wall_ms: int
    size_bytes: int
    kept: Literal["host", "operator", "fault"] | None


class TapeListing(_Event):
    """All parts that can be replayed."""

    parts: list[TapePart]


class TapeCamera(_Event):
    """The pictures of a camera other than the driving view, which begin `began_ms` into their part.

    Their address is ``media/``, the part's name, ``/`` and `number`.
    """

    number: int
    name: str
    began_ms: float


class TapeContent(_Event):
    """One part without its picture and sound, whose address is ``media/`` and its name.

    `problem` is a sentence about what could not be read, null if all could.
    """

    name: str
    began_wall_ms: float
    length_ms: float
    has_media: bool
    has_picture: bool
    has_sound: bool
    cameras: list[TapeCamera]
    events: list[Placed]
    problem: str | None


_ANY: TypeAdapter[TapeEvent] = TypeAdapter(Annotated[TapeEvent, Field(discriminator="type")])


def topic(event: type[TapeEvent]) -> str:
    """Return the MCAP topic of a kind of event: ``/wax/commanded`` and so on."""
    return f"/wax/{event.model_fields['type'].default}"


def parse_event(data: bytes) -> TapeEvent:
    """Parse an event of a tape; raises `ProtocolError`."""
    try:
        return _ANY.validate_json(data)
    except ValidationError as error:
        raise ProtocolError(
            "an event of the tape is not as this version of WAX writes it"
        ) from error
