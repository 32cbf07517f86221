"""Parses the commands that come from the house's broker. Pure."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from wax.protocol import messages

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping


@dataclass(frozen=True, slots=True)
class ReleaseAt:
    """Release the stop that was in force at a Unix time in ms: a broker may delay a message."""

    wall_ms: int


HouseAct = messages.Stop | messages.HoldQueue | messages.Close | messages.Blank | ReleaseAt

STOP: Final = "stop"
RELEASE: Final = "release"
OPEN: Final = "open"
PAUSED: Final = "paused"
BLANKED: Final = "blanked"
NAMES: Final = (STOP, RELEASE, OPEN, PAUSED, BLANKED)
"""The last level but one of a command's topic, as in ``home/rover/stop/set``."""

ON: Final = "ON"
OFF: Final = "OFF"
_SWITCHED: Final = {ON.encode(): True, OFF.encode(): False}
_SWITCHES: Final[Mapping[str, Callable[[bool], HouseAct]]] = {
    OPEN: lambda is_on: messages.Close(type="close", closed=not is_on),
    PAUSED: lambda is_on: messages.HoldQueue(type="hold_queue", held=is_on),
    BLANKED: lambda is_on: messages.Blank(type="blank", blanked=is_on),
}
_WALL_MS: Final = re.compile(rb"\d{13}")


def parse(name: str, payload: bytes) -> HouseAct | None:
    """Return what a message asks for; None if its payload is invalid.

    A Stop counts whatever its payload.
    """
    if name == STOP:
        return messages.Stop(type="stop")
    if name == RELEASE:
        return ReleaseAt(int(payload)) if _WALL_MS.fullmatch(payload) else None
    switch, is_on = _SWITCHES.get(name), _SWITCHED.get(payload)
    return None if switch is None or is_on is None else switch(is_on)
