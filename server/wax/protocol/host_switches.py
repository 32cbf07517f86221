"""What the host switches for everybody, each defined once. Pure.

A switch is set by a message of the host's page, and by home automation if it is `at_home`. The act
is recorded; the new value is kept over a restart and told to pages. A further switch is a message,
a field of `HostSwitches`, one of `HostSettings` and a row of `SWITCHES`, all of them here. If
setting it does more than change its value, `wax.session.host_acts` says what.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

from pydantic import BaseModel, ConfigDict, Field

from wax.protocol.model import Incoming, Outgoing

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping


class HoldQueue(Incoming):
    """Pause the queue, so that no turn begins or renews, or resume it."""

    type: Literal["hold_queue"]
    held: bool


class MuteVoices(Incoming):
    """Mute all voices at the robot, or unmute them."""

    type: Literal["mute_voices"]
    muted: bool


class Lock(Incoming):
    """Let only invited people stay, or admit strangers again."""

    type: Literal["lock"]
    locked: bool


class Close(Incoming):
    """Close to guests until the next opening hours begin, or reopen."""

    type: Literal["close"]
    closed: bool


class Blank(Incoming):
    """Show everybody a card instead of picture and sound, or show both again."""

    type: Literal["blank"]
    blanked: bool


class LimitSpeed(Incoming):
    """Limit how fast guests drive, as a fraction of the robot's limits; the host is not limited."""

    type: Literal["limit_speed"]
    fraction: Annotated[float, Field(ge=0.05, le=1)]


CameraDelay = Annotated[float, Field(ge=0, le=2000)]


class KeepCameraDelay(Incoming):
    """Keep what camera, exposure and screen add to the picture's age, in ms; null forgets it."""

    type: Literal["keep_camera_delay"]
    delay_ms: CameraDelay | None


SwitchAct = HoldQueue | MuteVoices | Lock | Close | Blank | LimitSpeed | KeepCameraDelay


class HostSettings(Outgoing):
    """What the host has decided for everybody.

    `held`: no turn begins. `locked`: only invited people may stay. `blanked`: a card replaces
    picture and sound, and the robot is stopped. `message` is for everybody, empty if there is none;
    it expires at `message_ends_server_ms`, never if that is null. `max_fraction` is the fraction of
    the robot's speed that guests may use. `camera_delay_ms` is what the driving view's camera,
    exposure and screen add to the picture's age, null unless the host has measured it.
    """

    held: bool = False
    locked: bool = False
    blanked: bool = False
    message: str = ""
    message_ends_server_ms: float | None = None
    max_fraction: float = 1.0
    camera_delay_ms: float | None = None


class HostSwitches(BaseModel):
    """The switches' values, by their names in the kept file, which older versions have written.

    While `is_blanked`, everybody sees a card instead of the picture and hears nothing, and the
    robot stays stopped. `max_fraction` of the robot's speed is what guests may use. The robot is
    closed until `closed_until_s` (since 1970), or until the host reopens it if that is None.
    """

    model_config = ConfigDict(frozen=True)

    is_held: bool = False
    is_blanked: bool = False
    are_voices_muted: bool = False
    max_fraction: Annotated[float, Field(ge=0, le=1)] = 1.0
    is_locked: bool = False
    is_closed: bool = False
    closed_until_s: float | None = None
    camera_delay_ms: CameraDelay | None = None

    def after(self, act: SwitchAct) -> HostSwitches:
        """Return the values once this act is done."""
        switch = SWITCHES[type(act)]
        return self.model_copy(update={switch.kept: getattr(act, switch.field)})

    def told(self) -> dict[str, Any]:
        """Return the values that pages are told, by their names in `HostSettings`."""
        return {one.told: getattr(self, one.kept) for one in SWITCHES.values() if one.told}


IN_DOUBT: Final = HostSwitches(is_blanked=True, are_voices_muted=True)
"""The values when the kept ones cannot be read: nobody sees, hears or speaks."""


@dataclass(frozen=True, slots=True)
class SwitchAtHome:
    """A switch in home automation: the last level of its topics, its name, what ON and OFF do."""

    topic: str
    name: str
    act: Callable[[bool], SwitchAct]


@dataclass(frozen=True, slots=True)
class HostSwitch:
    """One switch: the act's `field` is its new value, which is then `kept` in `HostSwitches`.

    `told` is its name in `HostSettings`, empty where pages learn of it by another message.
    """

    act: type[SwitchAct]
    field: str
    kept: str
    told: str = ""
    at_home: SwitchAtHome | None = None


_ROWS: Final = (
    HostSwitch(
        Close,
        field="closed",
        kept="is_closed",
        at_home=SwitchAtHome("open", "Open", lambda is_on: Close(type="close", closed=not is_on)),
    ),
    HostSwitch(
        HoldQueue,
        field="held",
        kept="is_held",
        told="held",
        at_home=SwitchAtHome(
            "paused", "Pause the queue", lambda is_on: HoldQueue(type="hold_queue", held=is_on)
        ),
    ),
    HostSwitch(
        Blank,
        field="blanked",
        kept="is_blanked",
        told="blanked",
        at_home=SwitchAtHome("blanked", "Blank", lambda is_on: Blank(type="blank", blanked=is_on)),
    ),
    HostSwitch(Lock, field="locked", kept="is_locked", told="locked"),
    HostSwitch(MuteVoices, field="muted", kept="are_voices_muted"),
    HostSwitch(LimitSpeed, field="fraction", kept="max_fraction", told="max_fraction"),
    HostSwitch(KeepCameraDelay, field="delay_ms", kept="camera_delay_ms", told="camera_delay_ms"),
)
SWITCHES: Final[Mapping[type[SwitchAct], HostSwitch]] = {one.act: one for one in _ROWS}
AT_HOME: Final[Mapping[str, SwitchAtHome]] = {
    one.at_home.topic: one.at_home for one in _ROWS if one.at_home is not None
}
"""The switches that home automation has, by their topics."""
