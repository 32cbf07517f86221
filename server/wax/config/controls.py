"""`[[controls]]` and `[[gauges]]`: what the robot has besides wheels, and what it measures."""

from __future__ import annotations

import re
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Final, Literal, Self

from pydantic import Field, model_validator

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

_TAKEN_BY_BROWSERS: Final = re.compile(
    r"Tab|Escape|CapsLock|Fn.*|F\d+|Unidentified|(Control|Alt|Meta|OS|Shift)(Left|Right)"
)

Label = Annotated[
    str,
    Field(
        pattern=r"^[^\x00-\x1f\x7f]{0,24}$",
        description="a text of at most 24 printable characters",
    ),
]
Choice = Annotated[
    str,
    Field(
        pattern=r"^[^\x00-\x1f\x7f]{1,24}$",
        description="a text of 1 to 24 printable characters",
    ),
]
Key = Annotated[
    str,
    Field(
        pattern=r"^[A-Za-z0-9]{0,24}$",
        description='empty, or a key by its place on the keyboard, as "KeyH" or "Digit1"',
    ),
]
_FROM_LOW_TO_HIGH: Final = ("stop_below", "warn_below", "warn_above", "stop_above")
Bound = Annotated[float, Field(ge=-10_000, le=10_000)]


class ControlSettings(ConfigTable):
    """`[[controls]]`: a button, switch, slider or choice that the page shows.

    A control that `moves` the robot, or a part of it, counts as driving: it must be held.
    """

    name: Name
    label: Label = ""
    kind: Literal["button", "toggle", "slider", "choice"]
    min: Bound = 0.0
    max: Bound = 1.0
    step: Annotated[float, Field(gt=0, le=10_000)] = 0.05
    choices: Annotated[list[Choice], Field(max_length=MAX_CHOICES)] = []
    key: Key = ""
    moves: bool = False
    roles: Annotated[list[ControlRole], Field(min_length=1, max_length=3)] = ["operator"]

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
        if not self.key:
            return self
        if self.kind not in ("button", "toggle"):
            raise ValueError(f"{self.name} is a {self.kind}, which no single key can set")
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
    """`[[gauges]]`: a number that the robot reports, with limits that warn or stop."""

    name: Name
    label: Label = ""
    unit: Annotated[
        str,
        Field(
            pattern=r"^[^\x00-\x1f\x7f]{0,8}$",
            description="a text of at most 8 printable characters",
        ),
    ] = ""
    min: Bound = 0.0
    max: Bound = 100.0
    decimals: Annotated[int, Field(ge=0, le=3)] = 1
    warn_below: Bound | None = None
    warn_above: Bound | None = None
    stop_below: Bound | None = None
    stop_above: Bound | None = None

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


def check_names(controls: Sequence[ControlSettings], gauges: Sequence[GaugeSettings]) -> None:
    """Raise `ValueError` if two have the same name or key."""
    own = "give each its own"
    check_apart(f"controls: two have the name {{}}; {own}", [one.name for one in controls])
    check_apart(f"controls: two have the key {{}}; {own}", [one.key for one in controls if one.key])
    check_apart(f"gauges: two have the name {{}}; {own}", [one.name for one in gauges])
