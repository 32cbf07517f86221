"""Parses the commands that come from the house's broker. Pure."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final

from wax.protocol import messages
from wax.protocol.host_switches import AT_HOME, SwitchAct


@dataclass(frozen=True, slots=True)
class ReleaseAt:
    """Release the stop that was in force at a Unix time in ms: a broker may delay a message."""

    wall_ms: int


HouseAct = messages.Stop | SwitchAct | ReleaseAt

STOP: Final = "stop"
RELEASE: Final = "release"
NAMES: Final = (STOP, RELEASE, *AT_HOME)
"""The last level but one of a command's topic, as in ``home/rover/stop/set``."""

ON: Final = "ON"
OFF: Final = "OFF"
_SWITCHED: Final = {ON.encode(): True, OFF.encode(): False}
_WALL_MS: Final = re.compile(rb"\d{13}")


def parse(name: str, payload: bytes) -> HouseAct | None:
    """Return what a message asks for; None if its payload is invalid.

    A Stop counts whatever its payload.
    """
    if name == STOP:
        return messages.Stop(type="stop")
    if name == RELEASE:
        return ReleaseAt(int(payload)) if _WALL_MS.fullmatch(payload) else None
    switch, is_on = AT_HOME.get(name), _SWITCHED.get(payload)
    return None if switch is None or is_on is None else switch.act(is_on)
