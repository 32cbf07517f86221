"""Attacks by the data channel: messages that any page may send, from many pages all the time."""

from __future__ import annotations

from contextlib import suppress
from itertools import cycle
from typing import TYPE_CHECKING, Any, Final

from aiortc.exceptions import InvalidStateError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from e2e.strangers.ground import Ground

WANTS: Final = [
    {"type": "want", "sound": True, "picture": True, "size": size, "policy": policy}
    for size in ("640x480", "320x240", "160x120")
    for policy in ("audio-master", "video-first")
]
_NAME: Final = "\ufdfa" * 20
"""Each character counts as 18 when names are compared by their look (NFKD)."""
QUEUE: Final = [{"type": "join"}, {"type": "leave"}]


async def says(ground: Ground, rate_hz: float, messages: Sequence[dict[str, Any]]) -> None:
    """Let each viewer send these messages in turn, over and over, at this rate."""
    spoken = {intruder: cycle(messages) for intruder in ground.intruders}
    async for intruder in ground.turns(rate_hz):
        with suppress(InvalidStateError):  # it was disconnected
            intruder.send(**next(spoken[intruder]))
            ground.account["messages"] += 1


async def renames(ground: Ground, rate_hz: float) -> None:
    """Let all of them take another name at the same moment."""
    number = 0
    async for _ in ground.ticks(1 / rate_hz):
        number += 1
        for place, intruder in enumerate(ground.intruders):
            with suppress(InvalidStateError):
                intruder.send(type="name", name=f"{place}-{number}{_NAME}")
                ground.account["messages"] += 1
