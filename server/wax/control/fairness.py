"""Who goes first among those who wait.

Nobody is kept from an idle robot by any of this: each rule only lets others go first.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from wax.config.settings import TurnSettings

WINDOW_S: Final = 3600.0
"""Shares are of the time that was driven during this long."""


@dataclass(frozen=True, slots=True)
class Person:
    """Who is behind one or more viewers: a browser, at an address. Both are only compared.

    `may_queue` is what the door says of them now.
    """

    key: str
    address: str = ""
    is_invited: bool = False
    may_queue: bool = True


@dataclass(frozen=True, slots=True)
class _Driven:
    person: Person
    begun_s: float
    ended_s: float

    def within(self, since_s: float) -> float:
        return self.ended_s - max(self.begun_s, since_s)


class Fairness:
    """Remembers the turns of the last hour, and ranks people by them."""

    def __init__(self, settings: TurnSettings) -> None:
        self._settings = settings
        self._driven: deque[_Driven] = deque()
        self._last_s: dict[str, float] = {}  # when each person's newest turn ended

    def drove(self, person: Person, begun_s: float, ended_s: float) -> None:
        """Remember a turn that is over."""
        self._driven.append(_Driven(person, begun_s, ended_s))
        self._last_s[person.key] = ended_s
        while self._driven[0].ended_s <= ended_s - WINDOW_S:
            old = self._driven.popleft()
            if self._last_s[old.person.key] == old.ended_s:
                del self._last_s[old.person.key]

    def rank(self, person: Person, now_s: float) -> tuple[bool, bool, bool]:
        """Return what sorts before what: rested, invited, within their share."""
        return (
            self.rests(person, now_s),
            self._settings.invited_first and not person.is_invited,
            self._is_over_share(person, now_s),
        )

    def yields(self, person: Person, now_s: float) -> bool:
        """Whether somebody who came later may go first."""
        return self.rests(person, now_s) or self._is_over_share(person, now_s)

    def rests(self, person: Person, now_s: float) -> bool:
        """Whether the cool-down after this person's last turn still lasts."""
        return now_s < self._last_s.get(person.key, -math.inf) + self._settings.cooldown_s

    def _is_over_share(self, person: Person, now_s: float) -> bool:
        shares = self._settings.max_share_per_person, self._settings.max_share_per_address
        if shares == (1.0, 1.0):
            return False
        since_s = now_s - WINDOW_S
        recent = [one for one in self._driven if one.ended_s > since_s]
        all_s = sum(one.within(since_s) for one in recent)
        own_s = sum(one.within(since_s) for one in recent if one.person.key == person.key)
        near_s = sum(one.within(since_s) for one in recent if one.person.address == person.address)
        return own_s > shares[0] * all_s or near_s > shares[1] * all_s
