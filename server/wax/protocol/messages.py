"""Every message between page and server, defined once; the page's types are made from these.

Two data channels, both opened by the page: ``drive`` (unordered, no retransmits) carries what is
worthless when late, ``state`` (reliable, ordered) the rest. On ``state`` all are JSON objects with
a ``type``; on ``drive``, twenty a second over a modem, arrays (`wax.protocol.compact`).
Times named ``…server_ms`` are on the server's monotonic clock.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Final, Literal, TypeVar, get_args

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from wax.errors import ProtocolError
from wax.protocol import compact

if TYPE_CHECKING:
    from collections.abc import Callable

MAX_DRIVE_BYTES = 512
MAX_STATE_BYTES = 2048
MAX_NAME_CHARS = 24

Ms = Annotated[float, Field(ge=-1e15, le=1e15)]
Counter = Annotated[int, Field(ge=0, le=2**53)]
Unit = Annotated[float, Field(ge=-1, le=1)]
Role = Literal["operator", "queued", "observer"]
Speed = Literal["slow", "fast"]


class _Incoming(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)


class _Outgoing(BaseModel):
    model_config = ConfigDict(frozen=True)


# --- drive channel, page → server ---------------------------------------------------------


class Drive(_Incoming):
    """A complete set-point: what the operator's hands say now.

    `linear` and `angular` are shares of the robot's limits (ahead and left are positive). `held` is
    the dead-man: some control is held down. Without it nothing moves, whatever the shares say.
    `axes` are the positions of those that have a hand on them now; the others keep theirs.
    `seen_server_ms` is the capture time of the newest presented picture, null when unknown.
    """

    type: Literal["drive"]
    seq: Counter
    turn: Counter
    sent_server_ms: Ms
    linear: Unit
    angular: Unit
    held: bool
    speed: Speed
    seen_server_ms: Ms | None
    axes: Annotated[dict[Annotated[str, Field(max_length=16)], Unit], Field(max_length=4)] = {}


class Ping(_Incoming):
    """The page's heartbeat, and one half of the clock alignment.

    `sent_page_ms` is the page's own clock, returned in the pong. `pong_id` is the newest pong
    received and `pong_held_ms` how long ago, from which the server learns the round trip.
    """

    type: Literal["ping"]
    id: Counter
    sent_page_ms: Ms
    pong_id: Counter | None
    pong_held_ms: Ms | None


class SoundReport(_Incoming):
    """How the sound plays; null where the browser does not tell.

    `age_ms` is from capture to the ear, `delay_ms` the part of it in the jitter buffer and
    `output_ms` that in the device (webrtc-stats, `media-playout`; a Bluetooth headset has much).
    `concealed_ms` and `played_ms` count from the beginning of this peer: what was made up, and all.
    """

    age_ms: Ms | None
    delay_ms: Ms | None
    output_ms: Ms | None
    concealed_ms: Ms | None
    played_ms: Ms | None


class PictureReport(_Incoming):
    """How the picture plays; null where the browser does not tell.

    `age_ms` is from capture to the eye, `delay_ms` the part of it in the jitter buffer, `rate_hz`
    the pictures shown in the last second. `frozen_ms` counts from the beginning of this peer.
    """

    age_ms: Ms | None
    delay_ms: Ms | None
    rate_hz: Annotated[float, Field(ge=0, le=1e6)] | None
    frozen_ms: Ms | None


class Report(_Incoming):
    """What the page measures, a few times a second; a stream that is off is null.

    `clock_error_ms` is how wrong the ages can be at most.
    """

    type: Literal["report"]
    sound: SoundReport | None
    picture: PictureReport | None
    clock_error_ms: Ms | None


# --- state channel, page → server ---------------------------------------------------------


class SetName(_Incoming):
    """The name that others see; trimmed and cut by the server."""

    type: Literal["name"]
    name: Annotated[str, Field(max_length=200)]


class Join(_Incoming):
    """Take a place at the end of the queue."""

    type: Literal["join"]


class Leave(_Incoming):
    """Leave the queue, or end one's turn."""

    type: Literal["leave"]


class Stop(_Incoming):
    """Stand still now, and until the stop is released."""

    type: Literal["stop"]


class Release(_Incoming):
    """End the stop with this number, deliberately; it moves nothing.

    One that is late, or is meant for an earlier stop, releases nothing.
    """

    type: Literal["release"]
    stop: Counter
    sent_server_ms: Ms


class Want(_Incoming):
    """Which streams this viewer wants and the largest picture; unknown sizes are refused.

    `policy` null leaves it to the role.
    """

    type: Literal["want"]
    sound: bool
    picture: bool
    size: Annotated[str, Field(max_length=16)]
    policy: Literal["audio-master", "video-first"] | None


class Received(_Incoming):
    """The last packet of a media unit has come; `rtp` is its RTP time.

    Sent only where `Hello` asks for it: for each picture, and for the sound as `Units` says.
    """

    type: Literal["received"]
    kind: Literal["audio", "video"]
    rtp: Annotated[int, Field(ge=0, lt=2**32)]


# --- server → page ------------------------------------------------------------------------


class Pong(_Outgoing):
    """Answer to a ping, on the drive channel."""

    type: Literal["pong"] = "pong"
    id: int
    sent_page_ms: float
    server_ms: float


class RobotInfo(_Outgoing):
    """What the robot can do, disclosed at connect."""

    kind: str
    max_linear_mps: float
    max_angular_rps: float
    slow_fraction: float
    axes: list[str]


class LossRules(_Outgoing):
    """What the robot does when something fails: disclosed at connect, never negotiable.

    A command is obeyed for `max_age_ms` beyond the line's own time, together at most
    `max_command_age_ms`; a picture older than these, beyond the line's own time, slows or stops.
    Where either was gone for less than `resume_within_ms`, what is still held drives on by itself.
    An operator who is silent for `lost_after_ms` is lost; their turn is kept for `Hello.grace_s`.
    The process that speaks with the robot stops it after `silence_ms`, null where that is the
    server itself; the robot itself after `robot_ttl_ms`, null where no watchdog of it is known of.
    With `soft_braking` what the operator lets go of, and what lapses, ends at the braking rate.
    """

    max_age_ms: float
    max_command_age_ms: float
    slow_picture_age_ms: float
    stop_picture_age_ms: float
    resume_within_ms: float
    lost_after_ms: float
    max_stop_distance_m: float
    silence_ms: float | None
    robot_ttl_ms: float | None
    soft_braking: bool
    stop_by: Literal["everybody", "operator"]


class Hello(_Outgoing):
    """The first message on the state channel; `acknowledge` asks the page for `Received`.

    `is_host` says that this page is open on the server's own machine.
    """

    type: Literal["hello"] = "hello"
    version: str
    viewer: int
    robot: RobotInfo
    sizes: list[str]
    turn_s: float
    grace_s: float
    command_rate_hz: float
    on_loss: LossRules
    is_host: bool
    acknowledge: bool


class ViewerInfo(_Outgoing):
    """One line of the queue. `place` is 0 for the operator, 1… for those waiting, null else."""

    id: int
    name: str
    role: Role
    place: int | None
    wait_s: float | None
    lost: bool


class TurnInfo(_Outgoing):
    """The turn that runs; `ends_server_ms` is null only when nobody drives."""

    number: int
    operator: int | None
    ends_server_ms: float | None


class RobotStatus(_Outgoing):
    """`problem` is a sentence, null when all is well.

    `bumpers` has a bit for each pressed bumper. Of the battery a robot tells the voltage, the
    fraction that is left (0 to 1), both, or null.
    """

    connected: bool
    problem: str | None
    bumpers: int
    battery_v: float | None
    battery_fraction: float | None


class SourceStatus(_Outgoing):
    """`problem` is a sentence, null when pictures or sound arrive."""

    problem: str | None


class StopInfo(_Outgoing):
    """The stop that is latched: its number, which only rises, and who pressed it."""

    number: int
    by: str


class RoomState(_Outgoing):
    """What everybody sees, sent on every change. `stop` is null while none is latched."""

    type: Literal["room"] = "room"
    viewers: list[ViewerInfo]
    turn: TurnInfo
    stop: StopInfo | None
    robot: RobotStatus
    video: SourceStatus
    audio: SourceStatus


class Playout(_Outgoing):
    """What the synchronisation policy wants of this page's two jitter buffers.

    null leaves a buffer to the browser. `reason` is a sentence for a person.
    """

    type: Literal["playout"] = "playout"
    policy: str
    sound_target_ms: float | None
    picture_target_ms: float | None
    reason: str


class Served(_Outgoing):
    """What this viewer is sent now, and what is known of their link; told when it changes.

    `rendition` null is no picture, `sound_mu_ms` null no sound. `picture_hz` is what is left of the
    rendition's rate by the layers sent. `redundancy` counts earlier units in each packet of sound.
    `layers` are the temporal layers sent and `layers_made` those that there are. `reason` is a
    sentence for a person: why it is this and not more. `in_step` false means that the link cannot
    carry both in step, and each plays as soon as it can.
    """

    type: Literal["served"] = "served"
    rendition: str | None
    picture_hz: float
    sound_mu_ms: int | None
    sound_bps: int
    redundancy: int
    link_bps: int
    used_bps: int
    queue_ms: float
    in_step: bool
    reason: str
    layers: int | None = None
    layers_made: int | None = None


class RtpClock(_Outgoing):
    """How RTP time maps to capture time: captured = origin + (rtp - rtp_origin) / rate."""

    type: Literal["rtp_clock"] = "rtp_clock"
    kind: Literal["audio", "video"]
    rtp_origin: int
    rate_hz: int
    origin_server_ms: float


class Units(_Outgoing):
    """Which packets end a media unit of the sound: one of them, and how far it is to the next.

    Both in RTP time, modulo 2³².
    """

    type: Literal["units"] = "units"
    last_rtp: int
    length: int


class DriveStatus(_Outgoing):
    """What becomes of the operator's commands; sent when it changes.

    `reason` is why the robot stands although it is told to move, or moves slower than it is told.
    """

    type: Literal["drive_status"] = "drive_status"
    moving: bool
    reason: str | None


class Notice(_Outgoing):
    """A sentence for this viewer, such as why a request was refused."""

    type: Literal["notice"] = "notice"
    text: str


DriveIn = Drive | Ping | Report
StateIn = SetName | Join | Leave | Stop | Release | Want | Received
DriveOut = Pong
StateOut = Hello | RoomState | Playout | Served | RtpClock | Units | DriveStatus | Notice

DRIVE_COLUMNS: Final = compact.by_type(*get_args(DriveIn), DriveOut)
"""What stands where in a row of the drive channel, by type."""

_DRIVE: TypeAdapter[DriveIn] = TypeAdapter(Annotated[DriveIn, Field(discriminator="type")])
_STATE: TypeAdapter[StateIn] = TypeAdapter(Annotated[StateIn, Field(discriminator="type")])


def parse_drive(data: str | bytes) -> DriveIn:
    """Bytes of the drive channel become a value; raises `ProtocolError`."""
    _limit(data, MAX_DRIVE_BYTES)
    named = compact.read(data, DRIVE_COLUMNS)
    return _valid(lambda: _DRIVE.validate_python(named))


def parse_state(data: str | bytes) -> StateIn:
    """Bytes of the state channel become a value; raises `ProtocolError`."""
    _limit(data, MAX_STATE_BYTES)
    return _valid(lambda: _STATE.validate_json(data))


_T = TypeVar("_T")


def _limit(data: str | bytes, limit: int) -> None:
    if len(data) > limit:
        raise ProtocolError(f"a message of {len(data)} is longer than {limit}")


def _valid(validate: Callable[[], _T]) -> _T:
    try:
        return validate()
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(str(part) for part in first["loc"])
        raise ProtocolError(f"{where}: {first['msg']}") from error
