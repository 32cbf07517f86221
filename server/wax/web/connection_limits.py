"""How many connections may be open, and which makes room for a newcomer. Pure.

A connection waits for a request (idle), reads one, or answers one. One address cannot take more
than its share. Where all places are taken, an idle connection makes room, or else that which has
been reading for longest: an honest browser sends a request in one piece.
"""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable


class Place:
    """One connection's place; `close` is called when it has to make room."""

    __slots__ = ("address", "close")

    def __init__(self, address: str, close: Callable[[], None]) -> None:
        self.address = address
        self.close = close


class ConnectionLimits:
    """The places of all connections; each is reading when it enters."""

    def __init__(self, *, most: int, most_per_address: int) -> None:
        self._most = most
        self._most_per_address = most_per_address
        self._places: set[Place] = set()
        self._per_address: Counter[str] = Counter()
        # Dictionaries keep the order in which their keys came.
        self._idle: dict[Place, None] = {}
        self._reading: dict[Place, None] = {}
        self.refused = 0
        self.displaced = 0

    def __contains__(self, place: Place) -> bool:
        return place in self._places

    def __len__(self) -> int:
        return len(self._places)

    def enter(self, address: str, close: Callable[[], None], *, limited: bool) -> Place | None:
        """Return a place, or None if there is none; `limited` addresses may have only so many."""
        if limited and self._per_address[address] >= self._most_per_address:
            own = next((one for one in self._idle if one.address == address), None)
            return self._enter(address, close, own)
        if len(self._places) >= self._most:
            longest = next(iter(self._idle), None) or next(iter(self._reading), None)
            return self._enter(address, close, longest)
        return self._add(address, close)

    def reads(self, place: Place) -> None:
        """Note that a request has begun to come."""
        self._idle.pop(place, None)
        self._reading.setdefault(place)

    def answers(self, place: Place) -> None:
        """Note that a request has come as a whole."""
        self._idle.pop(place, None)
        self._reading.pop(place, None)

    def idles(self, place: Place) -> None:
        """Note that it was answered, and the next request has not begun."""
        self._reading.pop(place, None)
        self._idle.setdefault(place)

    def leave(self, place: Place) -> None:
        """Give a place back; may be called again."""
        if place not in self._places:
            return
        self._places.discard(place)
        self._idle.pop(place, None)
        self._reading.pop(place, None)
        self._per_address[place.address] -= 1
        if not self._per_address[place.address]:
            del self._per_address[place.address]

    def close_all(self) -> None:
        """Close whatever is still open."""
        for place in list(self._places):
            place.close()

    def _enter(
        self, address: str, close: Callable[[], None], instead: Place | None
    ) -> Place | None:
        if instead is None:
            self.refused += 1
            return None
        self.displaced += 1
        self.leave(instead)
        instead.close()
        return self._add(address, close)

    def _add(self, address: str, close: Callable[[], None]) -> Place:
        place = Place(address, close)
        self._places.add(place)
        self._per_address[address] += 1
        self._reading[place] = None
        return place
