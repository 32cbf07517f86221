"""Who has a seat in the LiveKit rooms, and until when. Pure.

A seat ends unless its page renews it; so somebody who is sent away, or whose time is over, loses it
within minutes even if nobody tells the cluster.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

from wax.cluster.room_directory import person

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wax.access.admission import Visitor

SEAT_S: Final = 420.0
"""Longer than a token's life plus LiveKit's tolerance for clock error; pages renew before their
token expires, and return the seat when they are closed."""


@dataclass(frozen=True, slots=True)
class Seated:
    """One page that watches in a room; `rooms` are those offered to it, the current one first."""

    visitor: Visitor
    tab: str
    rooms: tuple[str, ...]
    until_s: float
    since_s: float

    @property
    def person(self) -> str:
        """The page's name in the rooms."""
        return person(self.visitor.identity, self.tab)


class Seats:
    """The seats in the order in which they end; each costs a few hundred bytes."""

    def __init__(self) -> None:
        self._seats: dict[str, Seated] = {}
        self._tabs: Counter[str] = Counter()
        self._newest: dict[str, str] = {}
        """The newest person by tab secret: without a cookie, each request is somebody new."""
        self._addresses: defaultdict[str, set[str]] = defaultdict(set)

    def __len__(self) -> int:
        return len(self._seats)

    def people(self) -> list[str]:
        """Return all pages' names in the rooms."""
        return list(self._seats)

    def get(self, name: str) -> Seated | None:
        """Return the seat of this person; None if they have none."""
        return self._seats.get(name)

    def at(self, address: str) -> int:
        """Return how many seats an address has."""
        return len(self._addresses.get(address, ()))

    def since_s(self, address: str) -> dict[str, float]:
        """Return since when each browser of an address has had a seat."""
        since_s: dict[str, float] = {}
        for one in (self._seats[name] for name in self._addresses.get(address, ())):
            who = one.visitor.identity
            since_s[who] = min(one.since_s, since_s.get(who, one.since_s))
        return since_s

    def of_identity(self, identity: str) -> list[Seated]:
        """Return all seats of one browser."""
        if not self._tabs[identity]:  # almost always, and this runs on every request
            return []
        return [one for one in self._seats.values() if one.visitor.identity == identity]

    def has(self, identity: str) -> bool:
        """Whether this browser has any."""
        return bool(identity) and self._tabs[identity] > 0

    def of_tab(self, tab: str) -> Seated | None:
        """Return the newest seat of this tab, of whichever browser; None if it has none."""
        return self._seats.get(self._newest.get(tab, ""))

    def give(self, visitor: Visitor, tab: str, rooms: Sequence[str], now_s: float) -> None:
        """Give a seat, or renew it."""
        before = self.remove(person(visitor.identity, tab))
        since_s = now_s if before is None else before.since_s
        seated = Seated(visitor, tab, tuple(rooms), now_s + SEAT_S, since_s)
        self._seats[seated.person] = seated
        self._tabs[visitor.identity] += 1
        self._newest[tab] = seated.person
        self._addresses[visitor.address].add(seated.person)

    def renew(self, visitor: Visitor) -> None:
        """Note what a proxy says now of everybody in this browser."""
        for one in self.of_identity(visitor.identity):
            if visitor.proves(one.visitor):
                seen = replace(one.visitor, vouched=visitor.vouched)
                self._seats[one.person] = replace(one, visitor=seen)

    def remove(self, name: str) -> Seated | None:
        """Remove this person's seat and return it; None if they have none."""
        seated = self._seats.pop(name, None)
        if seated is not None:
            address = seated.visitor.address
            if self._newest.get(seated.tab) == name:
                del self._newest[seated.tab]
            self._tabs[seated.visitor.identity] -= 1
            if not self._tabs[seated.visitor.identity]:
                del self._tabs[seated.visitor.identity]
            self._addresses[address].remove(name)
            if not self._addresses[address]:
                del self._addresses[address]
        return seated

    def expire(self, now_s: float) -> list[Seated]:
        """Remove and return the seats that nobody has renewed."""
        over: list[Seated] = []
        while self._seats:
            seated = next(iter(self._seats.values()))
            if now_s < seated.until_s:
                break
            self.remove(seated.person)
            over.append(seated)
        return over
