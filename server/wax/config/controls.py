"""`[[controls]]` and `[[gauges]]`: what the robot has besides wheels, and what it measures."""

from __future__ import annotations

import re
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Final, Literal, Self

from pydantic import Field, model_validator

from wax.config.allowed import printable, said
from wax.config.table import ConfigTable, Name, check_apart

if TYPE_CHECKING:
    from collections.abc import Sequence

MAX_CONTROLS: Final = 12
MAX_GAUGES: Final = 12
MAX_CHOICES: Final = 8

ControlRole = Literal["operator", "host", "observer"]

DRIVING_KEYS: Final = frozenset(
    {"ArrowUp", "ArrowDown", "ArrowLeft", "ArrowRight", "Space", "Enter", "NumpadEnter"}
    | {f"Key{letter}" for letter in "WSADFJLIKOTCMN"}
)
"""The keys that the page itself uses by default (`web/src/drive/keyMap.ts`)."""
LATERAL_KEYS: Final = frozenset({"KeyQ", "KeyE"})
"""Those that it uses only for a robot that moves sideways."""

LATERAL_BUTTONS: Final = frozenset({"LB", "RB"})
"""The gamepad's buttons that it uses only for a robot that moves sideways."""

_TAKEN_BY_BROWSERS: Final = re.compile(
    r"Tab|Escape|CapsLock|Fn.*|F\d+|Unidentified|(Control|Alt|Meta|OS|Shift)(Left|Right)"
)

Label = Annotated[str, printable(0, 24)]
Choice = Annotated[str, printable(1, 24)]
Key = Annotated[
    str,
    Field(pattern=r"^[A-Za-z0-9]{0,24}$"),
    said('empty, or a key by its place on the keyboard, as "KeyH" or "Digit1"'),
]
_FROM_LOW_TO_HIGH: Final = ("stop_below", "warn_below", "warn_above", "stop_above")
Bound = Annotated[float, Field(ge=-10_000, le=10_000)]


class ControlSettings(ConfigTable):
    """What the robot has besides wheels and axes, as far as its driver knows it by name: lights, a
    horn, a gripper. The page shows each to those who may use it. Whatever moves counts as
    driving: only while it is held, never while a Stop is in force, and whatever releases the
    controls releases it.

    The simulated robot has these:
      controls = [
        { name = "lamp", label = "Lamp", kind = "toggle", key = "KeyH", roles = ["operator", "host"] },
        { name = "horn", label = "Horn", kind = "button", key = "KeyG" },
        { name = "brightness", label = "Brightness", kind = "slider", min = 20.0, max = 100.0, step = 5.0 },
        { name = "light", label = "Light", kind = "choice", choices = ["white", "warm", "red"] },
        { name = "look_around", label = "Look around", kind = "button", moves = true },
      ]
    """  # noqa: E501

    name: Name
    """What the driver calls it."""
    label: Label = ""
    """What people call it, "" for its name."""
    kind: Literal["button", "toggle", "slider", "choice"]
    """How it is used: a button lasts while it is held, a toggle until it is pressed again."""
    min: Bound = 0.0
    """A slider's least value."""
    max: Bound = 1.0
    """A slider's largest value."""
    step: Annotated[float, Field(gt=0, le=10_000)] = 0.05
    """The distance from one of a slider's values to the next."""
    choices: Annotated[list[Choice], Field(max_length=MAX_CHOICES)] = []
    """The values of a choice."""
    key: Key = ""
    """The key that presses a button or a toggle; whoever has given it another meaning keeps
    that."""
    pad_button: Literal["", "X", "Y", "LB", "RB", "View", "LS", "RS"] = ""
    """The button of a gamepad that presses it, as labelled on an Xbox's; everybody can choose
    another in the page's settings."""
    moves: bool = False
    """Whether it moves the robot or a part of it; a button or a slider then, for whoever drives."""
    roles: Annotated[list[ControlRole], Field(min_length=1, max_length=3)] = ["operator"]
    """Who may use it; an observer is everybody who watches."""

    @property
    def is_held(self) -> bool:
        """Whether it acts only while somebody holds it."""
        return self.moves or self.kind == "button"

    @model_validator(mode="after")
    def _is_of_its_kind(self) -> Self:
        """Refuse keys that this kind of control does not use, or lacks."""
        fields = type(self).model_fields
        for name in ("min", "max", "step"):
            if self.kind != "slider" and getattr(self, name) != fields[name].default:
                raise ValueError(
                    f"{self.name} is a {self.kind}, which has no {name}; leave it out, or write"
                    ' kind = "slider"'
                )
        if self.kind == "slider" and not 0 < self.step <= self.max - self.min:
            raise ValueError(
                f"{self.name} goes from {self.min:g} to {self.max:g} in steps of {self.step:g};"
                " max must be above min by a step at least"
            )
        if self.kind != "choice" and self.choices:
            raise ValueError(
                f'{self.name} is a {self.kind}, which has no choices; write kind = "choice"'
            )
        if self.kind == "choice" and not 2 <= len(set(self.choices)) == len(self.choices):
            raise ValueError(f"{self.name} needs two choices at least, each with words of its own")
        return self

    @model_validator(mode="after")
    def _key_is_free(self) -> Self:
        if (self.key or self.pad_button) and self.kind not in ("button", "toggle"):
            raise ValueError(f"{self.name} is a {self.kind}, which no single key can set")
        if not self.key:
            return self
        if self.key in DRIVING_KEYS:
            raise ValueError(f"{self.name} has the key {self.key}, which drives or stops already")
        if _TAKEN_BY_BROWSERS.fullmatch(self.key):
            raise ValueError(f"{self.name} has the key {self.key}, which browsers need themselves")
        return self

    @model_validator(mode="after")
    def _motion_is_held_by_who_drives(self) -> Self:
        if not self.moves:
            return self
        if self.kind not in ("button", "slider"):
            raise ValueError(
                f"{self.name} moves, so it must be held; a {self.kind} cannot be: write kind ="
                ' "button" or "slider"'
            )
        if self.roles != ["operator"]:
            raise ValueError(
                f'{self.name} moves, so it is for whoever drives alone: write roles = ["operator"]'
            )
        return self


class GaugeSettings(ConfigTable):
    """Numbers that the robot tells, shown in the page's details and, beyond a limit, over the
    picture. Nobody drives while a number is beyond a limit that stops, or is not told although it
    has such a limit, and for two seconds after. Besides what its driver names, each robot that
    tells its battery has battery_v and battery_fraction (0 to 1); the simulated one has motor_c,
    how warm its motors are.

    An example:
      gauges = [
        { name = "motor_c", label = "Motors", unit = "°C", decimals = 0, warn_above = 60.0, stop_above = 85.0 },
      ]
    """  # noqa: E501

    name: Name
    """What the driver calls it."""
    label: Label = ""
    """What people call it, "" for its name."""
    unit: Annotated[str, printable(0, 8)] = ""
    """The unit that is shown."""
    min: Bound = 0.0
    """Where its scale begins."""
    max: Bound = 100.0
    """Where its scale ends."""
    decimals: Annotated[int, Field(ge=0, le=3)] = 1
    """How many decimals are shown."""
    warn_below: Bound | None = None
    """Warns people of less than this."""
    warn_above: Bound | None = None
    """Warns people of more than this."""
    stop_below: Bound | None = None
    """Stops the robot at less than this."""
    stop_above: Bound | None = None
    """Stops the robot at more than this."""

    @property
    def may_stop(self) -> bool:
        """Whether one of its limits stops the robot."""
        return self.stop_below is not None or self.stop_above is not None

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if not self.min < self.max:
            raise ValueError(
                f"{self.name} goes from {self.min:g} to {self.max:g}; max must be above min"
            )
        limits = [(name, getattr(self, name)) for name in _FROM_LOW_TO_HIGH]
        known = [(name, value) for name, value in limits if value is not None]
        for (lower, low), (upper, high) in pairwise(known):
            is_between = lower.endswith("below") and upper.endswith("above")
            if low > high or (is_between and low == high):
                raise ValueError(
                    f"{self.name}: {lower} is {low:g} and {upper} {high:g}; {upper} must be the"
                    " larger one"
                )
        return self


def check_controls(
    controls: Sequence[ControlSettings], gauges: Sequence[GaugeSettings], lateral_mps: float
) -> None:
    """Raise `ValueError` if two have the same name, key or button, or one's drives sideways.

    `lateral_mps` is the robot's highest speed sideways, 0 if it cannot.
    """
    for one in controls:
        for what, pressed in (("key", one.key), ("pad_button", one.pad_button)):
            if lateral_mps > 0 and pressed in LATERAL_KEYS | LATERAL_BUTTONS:
                raise ValueError(
                    f"controls: {one.name} has the {what} {pressed}, which moves this robot"
                    " sideways; give it another"
                )
    own = "give each its own"
    check_apart(f"controls: two have the name {{}}; {own}", [one.name for one in controls])
    for what in ("key", "pad_button"):
        used = [pressed for one in controls if (pressed := getattr(one, what))]
        check_apart(f"controls: two have the {what} {{}}; {own}", used)
    check_apart(f"gauges: two have the name {{}}; {own}", [one.name for one in gauges])
