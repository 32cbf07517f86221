"""Events for the host's programs, each one JSON object; `[[hook]]` posts them.

`name` is the name that somebody chose, null unless the configuration includes names. No event has
an address or a fault's details: `why` is the code of its sentence in `sentences.json`.
"""

from __future__ import annotations

from typing import Annotated, Any, Final, Literal, get_args

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter

VERSION: Final = 1
"""The version of all events. Any change raises it, except a new kind of event or a new field."""

Part = Literal["camera", "microphone", "robot", "battery", "gauge"]
StopRole = Literal["observer", "operator", "host", "house"]
WhyEnded = Literal["expired", "left", "gone", "idle", "ended", "not_allowed", "server_ending"]


class _Event(BaseModel):
    """`timestamp` is when it happened, in UTC by RFC 3339."""

    model_config = ConfigDict(
        frozen=True, allow_inf_nan=False, json_schema_serialization_defaults_required=True
    )

    version: Literal[1] = VERSION
    timestamp: str = Field(default_factory=str, json_schema_extra={"format": "date-time"})


class _OfPerson(_Event):
    name: str | None


class ServerEvent(_Event):
    """The page can be opened; or the server stops, robot first. `software` is its version."""

    type: Literal["server.ready", "server.ending"]
    software: str


class DoorEvent(_Event):
    """Guests are admitted from now on, or no longer; one of the two follows each start."""

    type: Literal["door.opened", "door.closed"]


class QueueEvent(_Event):
    """Somebody waits for a turn, or nobody any more."""

    type: Literal["queue.waiting", "queue.empty"]


class TurnBegan(_OfPerson):
    """The turn of the viewer with this number begins.

    In a flood of turns in which nobody drives, most turns are left out, with their numbers.
    """

    type: Literal["turn.began"] = "turn.began"
    turn: int
    viewer: int


class TurnEndedEvent(_OfPerson):
    """The turn has ended; `gone` means that their connection did not come back."""

    type: Literal["turn.ended"] = "turn.ended"
    turn: int
    viewer: int
    why: WhyEnded


class StopEvent(_OfPerson):
    """Somebody pressed Stop, or released the stop with this number; it lasts until released."""

    type: Literal["stop.pressed", "stop.released"]
    stop: int
    role: StopRole


class StoppedByItself(_OfPerson):
    """The robot was stopped while somebody drove, without a press of Stop; at most one a second.

    `why` is a short name: `too_old` for late commands, `blind` for a late picture, `robot` for what
    the robot itself reports, and so on.
    """

    type: Literal["stop.automatic"] = "stop.automatic"
    viewer: int
    why: str


class FaultEvent(_Event):
    """A part has failed for some seconds, or has worked again for ten.

    `which` is the name of a camera other than the driving view, or of a gauge, whose `why` is
    `warn` or `stop`. A battery is low below 15 %, until it is above 20 %.
    """

    type: Literal["fault.began", "fault.mended"]
    part: Part
    which: str | None
    why: str


class ClusterEvent(_Event):
    """A room of `[[publish]]`, numbered from 1, gets no picture, or gets one again."""

    type: Literal["cluster.lost", "cluster.back"]
    room: int


class TunnelEvent(_Event):
    """The page cannot be reached through `[door]`, or can be again."""

    type: Literal["tunnel.lost", "tunnel.back"]
    why: str


class Removed(_OfPerson):
    """The host removed somebody, or banned them for a day."""

    type: Literal["viewer.removed", "viewer.banned"]
    viewer: int


class TapeKept(_Event):
    """The last two minutes of the tape are kept; `by` says at whose request, or after a fault."""

    type: Literal["tape.kept"] = "tape.kept"
    by: Literal["host", "operator", "fault"]


class HookTested(_Event):
    """A sample, sent by `wax hook test`."""

    type: Literal["hook.test"] = "hook.test"


Event = (
    ServerEvent
    | DoorEvent
    | QueueEvent
    | TurnBegan
    | TurnEndedEvent
    | StopEvent
    | StoppedByItself
    | FaultEvent
    | ClusterEvent
    | TunnelEvent
    | Removed
    | TapeKept
    | HookTested
)

MODELS: Final = get_args(Event)
NAMES: Final[tuple[str, ...]] = tuple(
    name
    for model in MODELS
    for name in get_args(model.model_fields["type"].annotation)
    if model is not HookTested
)
"""The event types that a hook can subscribe to; every hook gets a sample."""


def nameless(event: Event) -> Event:
    """Return the event without a person's name."""
    return event.model_copy(update={"name": None}) if isinstance(event, _OfPerson) else event


def schema() -> dict[str, Any]:
    """Return the JSON Schema of all events."""
    told: TypeAdapter[Event] = TypeAdapter(Annotated[Event, Field(discriminator="type")])
    return {"title": "Events of WAX"} | told.json_schema(mode="serialization")
