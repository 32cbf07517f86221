"""Which room an observer is sent to. Pure."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from wax.errors import StartError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.config.publish import PublishSettings
    from wax.config.settings import RenditionSettings

_SMALL: Final = 0.25
"""The smaller of two renditions takes at most this share of the larger one's rate."""
_SOUND_BPS: Final = 50_000
"""With the headers of its fifty packets a second."""
_SEATS: Final = 2
"""Rooms that a page is told of: one to watch, and one to go to when that fails."""


@dataclass(slots=True)
class Occupancy:
    """How many are in one room.

    `sent` counts those who were sent there since it was counted, `coming` those in the interval
    before, whom LiveKit's count, which is seconds old, may not include.
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
        """Note how many there are now."""
        self.counted, self.coming, self.sent = people, self.sent, 0


def choose(live: Sequence[Occupancy], before: Sequence[str] = ()) -> list[Occupancy]:
    """Return the room with the most free places, and a second one; empty where all are full.

    `live` are those that are published to. The second may be full: it is for when the first one is
    gone, and everybody in it. Whoever was sent `before` to some of them keeps those that are live.
    """
    kept = [one for name in before for one in live if one.name == name]
    others = sorted((one for one in live if one not in kept), key=lambda one: -one.free)
    if not kept:
        if not others or others[0].free == 0:
            return []
        others[0].sent += 1
    return [*kept, *others][:_SEATS]


def published(ladder: Sequence[RenditionSettings]) -> list[RenditionSettings]:
    """Return the two renditions that are published: the best, and one for a thin link."""
    best = ladder[0]
    small = next((one for one in ladder if one.bitrate_bps <= _SMALL * best.bitrate_bps), None)
    return [best] if small is None else [best, small]


def upload_left_bps(
    upload_bps: int, ladder: Sequence[RenditionSettings], rooms: Sequence[PublishSettings]
) -> int:
    """Return what the rooms leave of an upload to the viewers here; 0 is no limit.

    Raises `StartError` where they leave nothing.
    """
    if not upload_bps:
        return 0
    chosen = published(ladder)
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
    """Return under which name somebody is in a room, from which nobody learns their cookie."""
    return "p-" + hashlib.sha256(f"{identity} {tab}".encode()).hexdigest()[:24]
