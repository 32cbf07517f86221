"""What is told to programs of the host's, each event one JSON object; `[[hook]]` posts them.

`name` is what somebody calls themselves, null unless the configuration lets names out. No event has
an address, nor the particulars of a fault: `why` is the code of its sentence in `sentences.json`.
"""

from __future__ import annotations

from typing import Annotated, Any, Final, Literal, get_args

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter

VERSION: Final = 1
"""Of all events. A new kind of event or a new field does not raise it; anything else does."""

Part = Literal["camera", "microphone", "robot", "battery", "gauge"]
StopRole = Literal["observer", "operator", "host", "house"]
WhyEnded = Literal["expired", "left", "gone", "idle", "ended", "not_allowed", "server_ending"]


class _Event(BaseModel):
    """`timestamp` is when it happened, in UTC as RFC 3339 has it."""

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
    """Guests are let in from now on, or not any more; one of the two follows each start."""

    type: Literal["door.opened", "door.closed"]


class QueueEvent(_Event):
    """Somebody waits for a turn, or nobody any more."""

    type: Literal["queue.waiting", "queue.empty"]


class TurnBegan(_OfPerson):
    """The viewer with this number drives.

    Of a flood of turns in which nobody drives most are left out, and so are their numbers.
    """

    type: Literal["turn.began"] = "turn.began"
    turn: int
    viewer: int


class TurnEndedEvent(_OfPerson):
    """They do not drive any more; `gone` is that their connection did not come back."""

    type: Literal["turn.ended"] = "turn.ended"
    turn: int
    viewer: int
    why: WhyEnded


class StopEvent(_OfPerson):
    """Somebody pressed Stop, or released the stop with this number. The stop lasts until then."""

    type: Literal["stop.pressed", "stop.released"]
    stop: int
    role: StopRole


class StoppedByItself(_OfPerson):
    """The robot was stopped while somebody drove, and not by anybody's wish; one a second at most.

    `why` is a short name: `too_old` for late commands, `blind` for a late picture, `robot` for what
    the robot itself says, and so on.
    """

    type: Literal["stop.automatic"] = "stop.automatic"
    viewer: int
    why: str


class FaultEvent(_Event):
    """Something has failed for some seconds, or is well again for ten.

    `which` is the name of a camera beside the driving view, or of a gauge, whose `why` is `warn` or
    `stop`. A battery is low below 15 %, until it is above 20 %.
    """

    type: Literal["fault.began", "fault.mended"]
    part: Part
    which: str | None
    why: str


class ClusterEvent(_Event):
    """A room of `[[publish]]`, the first is 1, gets no picture, or gets one again."""

    type: Literal["cluster.lost", "cluster.back"]
    room: int


class TunnelEvent(_Event):
    """People elsewhere do not reach the page through `[door]`, or do again."""

    type: Literal["tunnel.lost", "tunnel.back"]
    why: str


class Removed(_OfPerson):
    """The host removed somebody, or banned them for a day."""

    type: Literal["viewer.removed", "viewer.banned"]
    viewer: int


class TapeKept(_Event):
    """The last two minutes of the tape are kept, by whom or because of what."""

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
"""What a hook may ask for; a sample comes unasked."""


def nameless(event: Event) -> Event:
    """Return the event without what somebody calls themselves."""
    return event.model_copy(update={"name": None}) if isinstance(event, _OfPerson) else event


def schema() -> dict[str, Any]:
    """Return the JSON Schema of all events."""
    told: TypeAdapter[Event] = TypeAdapter(Annotated[Event, Field(discriminator="type")])
    return {"title": "Events of WAX"} | told.json_schema(mode="serialization")
