"""How many connections may be open, and which makes room for a newcomer. Pure.

A connection waits for a request (idle), reads one, or answers one. One address cannot take more
than its share. Where all places are taken, the address that has most gives one: an idle one, or
that which has been reading for longest, since an honest browser sends a request in one piece, or
else the one whose answer takes longest. So whoever has few keeps them, however slow their link is.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    State = Literal["idle", "reading", "answering"]

_ANSWERS_S: Final = 1.0
"""An answer under way is not broken off before, but by an address that has fewer places."""


class Place:
    """One connection's place; `close` is called when it has to make room."""

    __slots__ = ("address", "close", "since_s", "state")

    def __init__(self, address: str, close: Callable[[], None], now_s: float) -> None:
        self.address = address
        self.close = close
        self.since_s = now_s
        self.state: State = "reading"


class ConnectionLimits:
    """The places of all connections; each is reading when it enters."""

    def __init__(self, *, most: int, most_per_address: int) -> None:
        self._most = most
        self._most_per_address = most_per_address
        self._number = 0
        self._by_address: dict[str, dict[Place, None]] = {}
        """Each in the order in which their requests began; dictionaries keep it."""
        self.refused = 0
        self.displaced = 0

    def __contains__(self, place: Place) -> bool:
        return place in self._by_address.get(place.address, ())

    def __len__(self) -> int:
        return self._number

    def of(self, address: str) -> int:
        """Return how many places an address has."""
        return len(self._by_address.get(address, ()))

    def enter(
        self, address: str, close: Callable[[], None], now_s: float, *, limited: bool
    ) -> Place | None:
        """Return a place, or None if there is none; `limited` addresses may have only so many."""
        own = self._by_address.get(address, ())
        if limited and len(own) >= self._most_per_address:
            has_room = self._displace(own, now_s, least_s=_ANSWERS_S)
        elif self._number >= self._most:
            most = max(self._by_address.values(), key=len)
            has_fewer = len(own) + 1 < len(most)
            has_room = self._displace(most, now_s, least_s=0.0 if has_fewer else _ANSWERS_S)
        else:
            has_room = True
        if not has_room:
            self.refused += 1
            return None
        place = Place(address, close, now_s)
        self._add(place)
        return place

    def begins(self, place: Place, now_s: float) -> None:
        """Note that a request has begun to come."""
        place.state, place.since_s = "reading", now_s
        others = self._by_address.get(place.address, {})
        if place in others:
            del others[place]
            others[place] = None

    def answers(self, place: Place) -> None:
        """Note that a request has come as a whole."""
        place.state = "answering"

    def idles(self, place: Place) -> None:
        """Note that it was answered, and the next request has not begun."""
        place.state = "idle"

    def is_for(self, place: Place, address: str, now_s: float, *, limited: bool) -> bool:
        """Count the place of a proxy's connection as that of the address for which it asks.

        False if that one has no room.
        """
        if place not in self or place.address == address:
            return True
        own = self._by_address.get(address, ())
        if (
            limited
            and len(own) >= self._most_per_address
            and not self._displace(own, now_s, least_s=_ANSWERS_S)
        ):
            self.refused += 1
            return False
        self.leave(place)
        place.address = address
        self._add(place)
        return True

    def leave(self, place: Place) -> None:
        """Give a place back; may be called again."""
        if place not in self:
            return
        own = self._by_address[place.address]
        del own[place]
        if not own:
            del self._by_address[place.address]
        self._number -= 1

    def close_all(self) -> None:
        """Close whatever is still open."""
        for place in [one for own in self._by_address.values() for one in own]:
            place.close()

    def _displace(self, places: Collection[Place], now_s: float, *, least_s: float) -> bool:
        """Take the place from one of these; False if none of them has been at work for long."""
        first: dict[State, Place] = {}
        for place in places:
            first.setdefault(place.state, place)
        longest = first.get("idle") or first.get("reading") or first.get("answering")
        if longest is None:
            return False
        if longest.state == "answering" and now_s - longest.since_s < least_s:
            return False
        self.displaced += 1
        self.leave(longest)
        longest.close()
        return True

    def _add(self, place: Place) -> None:
        self._by_address.setdefault(place.address, {})[place] = None
        self._number += 1
