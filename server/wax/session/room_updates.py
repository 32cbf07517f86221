"""When changes of the room are sent to everybody. Pure.

One message has all changes since the last one. A turn, a Stop or a fault of the robot is sent at
once; who is here and in which place once a second, and so are names; what changes all the time,
such as an estimated wait, every five seconds, the wait also with each turn. Short bursts are not
delayed. So whatever one viewer does costs the others' links less than 2 kB a second.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from wax.protocol.robot_report import ROBOT_NUMBERS
from wax.protocol.room_change import between
from wax.rate_limits import TokenBucket

if TYPE_CHECKING:
    from wax.protocol.messages import RoomChange, RoomState, ViewerInfo

_URGENT_HZ: Final = 2.0
_URGENT_BURST: Final = 4
_PLACES_HZ: Final = 1.0
_PLACES_BURST: Final = 4
_NAMES_HZ: Final = 1.0
_FLEETING_EVERY_S: Final = 5.0
_FLEETING: Final[dict[str, Any]] = {"robot": {"gauges", *ROBOT_NUMBERS}}
_LISTS: Final = {"type": True, "viewers": True}


class RoomUpdates:
    """Tracks the state that everybody has; `told` is that state, for a new viewer."""

    def __init__(self, now_s: float) -> None:
        self.told: RoomState | None = None
        self._urgent = TokenBucket(rate_hz=_URGENT_HZ, burst=_URGENT_BURST)
        self._places = TokenBucket(rate_hz=_PLACES_HZ, burst=_PLACES_BURST)
        self._names = TokenBucket(rate_hz=_NAMES_HZ, burst=1)
        self._refreshed_s = now_s

    def next(self, room: RoomState, now_s: float) -> RoomState | RoomChange | None:
        """Return what to send to all who are connected now, None for nothing yet."""
        told = self.told
        if told is None:
            self.told, self._refreshed_s = room, now_s
            return room
        if now_s - self._refreshed_s >= _FLEETING_EVERY_S:
            self._refreshed_s = now_s
            if room == told:
                return None
        else:
            if room.turn.operator == told.turn.operator:
                room = _without_fleeting(told, room)
            allowed = self._allowed(told, room)
            if allowed is None or not allowed.take(now_s):
                return None
        self.told = room
        return between(told, room)

    def _allowed(self, told: RoomState, room: RoomState) -> TokenBucket | None:
        """Return the rate limit of what has changed, None if nothing has."""
        before, after = (one.model_dump(exclude=_LISTS | _FLEETING) for one in (told, room))
        if before != after:
            return self._urgent
        if told.viewers == room.viewers:
            return None
        return self._names if _are_only_renamed(told.viewers, room.viewers) else self._places


def _are_only_renamed(told: list[ViewerInfo], now: list[ViewerInfo]) -> bool:
    return len(told) == len(now) and all(
        one is other or vars(one) | {"name": other.name} == vars(other)
        for one, other in zip(told, now, strict=True)
    )


def _without_fleeting(told: RoomState, room: RoomState) -> RoomState:
    """Leave a viewer's estimated wait as it was sent if nothing else of theirs has changed."""
    known = {line.id: line for line in told.viewers}
    return room.model_copy(
        update={"viewers": [_line(known.get(one.id), one) for one in room.viewers]}
    )


def _line(before: ViewerInfo | None, now: ViewerInfo) -> ViewerInfo:
    if before is None or vars(now) | {"wait_s": before.wait_s} != vars(before):
        return now
    return before
