"""Chooses the room for an observer, and the renditions to publish. Pure."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from wax.errors import StartError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.config.publish import PublishSettings
    from wax.config.video import RenditionSettings

_SMALL: Final = 0.25
"""The smaller of two renditions has at most this share of the larger one's bitrate."""
_SOUND_BPS: Final = 50_000
"""The sound's bitrate with the headers of its fifty packets a second."""
_SEATS: Final = 2
"""Rooms that a page gets: one to watch, and one to fall back on."""


@dataclass(slots=True)
class Occupancy:
    """How many viewers are in one room.

    `sent` counts those sent there since the last count, `coming` those sent in the interval before
    it: LiveKit's count is seconds old and may miss them.
    """

    name: str
    most: int
    counted: int = 0
    coming: int = 0
    sent: int = 0

    @property
    def free(self) -> int:
        return max(self.most - self.counted - self.coming - self.sent, 0)

    def count(self, people: int) -> None:
        """Note a new count."""
        self.counted, self.coming, self.sent = people, self.sent, 0


def choose(live: Sequence[Occupancy], before: Sequence[str] = ()) -> list[Occupancy]:
    """Return the room with the most free places and a second one; empty if all are full.

    `live` are the rooms that are published to. The second may be full: it is needed when the first
    is gone, with everybody in it. Rooms in `before`, if live, are kept and come first.
    """
    kept = [one for name in before for one in live if one.name == name]
    others = sorted((one for one in live if one not in kept), key=lambda one: -one.free)
    if not kept:
        if not others or others[0].free == 0:
            return []
        others[0].sent += 1
    return [*kept, *others][:_SEATS]


def published(
    ladder: Sequence[RenditionSettings], most_bps: float = math.inf
) -> list[RenditionSettings]:
    """Return the renditions to publish: the best of at most this rate, and one for a thin link.

    The latter is left out if the ladder has none.
    """
    best = next((one for one in ladder if one.bitrate_bps <= most_bps), ladder[-1])
    small = next((one for one in ladder if one.bitrate_bps <= _SMALL * best.bitrate_bps), None)
    return [best] if small is None else [best, small]


def upload_left_bps(
    upload_bps: int, chosen: Sequence[RenditionSettings], rooms: Sequence[PublishSettings]
) -> int:
    """Return the upload that the rooms leave to this server's own viewers; 0 is no limit.

    `chosen` are the renditions that are published. Raises `StartError` if they leave nothing.
    """
    if not upload_bps:
        return 0
    bits = sum(
        _SOUND_BPS + sum(one.bitrate_bps for one in (chosen if room.livekit else chosen[:1]))
        for room in rooms
    )
    if bits >= upload_bps:
        raise StartError(
            f"network.upload_bps: {upload_bps} does not even carry the rooms of publish, which"
            f" take {bits}; name fewer of them, or choose smaller video.renditions"
        )
    return upload_bps - bits


def person(identity: str, tab: str) -> str:
    """Return somebody's name in a room, which does not reveal their cookie."""
    return "p-" + hashlib.sha256(f"{identity} {tab}".encode()).hexdigest()[:24]
