"""Who goes first among the people in the queue.

No rule here keeps anybody from an idle robot: each only lets others go first.
"""

from __future__ import annotations

import math
from collections import Counter, deque
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from wax.config.turns import TurnSettings

WINDOW_S: Final = 3600.0
"""Shares are computed over the turns that ended within this time, or up to a minute before."""
_MINUTE_S: Final = 60.0


@dataclass(frozen=True, slots=True)
class Person:
    """Who is behind one or more viewers: a browser (`key`) at an address, only ever compared.

    `may_queue` says whether admission allows them a place in the queue now.
    """

    key: str
    address: str = ""
    is_invited: bool = False
    may_queue: bool = True


@dataclass(slots=True)
class _Minute:
    """How long each person at each address drove, in turns that ended in the minute to `end_s`."""

    end_s: float
    driven_ms: Counter[tuple[str, str]] = field(default_factory=Counter)


class Fairness:
    """Remembers the turns of the last hour, minute by minute, and ranks people by them.

    The cost of ranking does not grow with the number of turns; memory grows only with people.
    """

    def __init__(self, settings: TurnSettings) -> None:
        self._settings = settings
        self._minutes: deque[_Minute] = deque()
        self._all_ms = 0
        self._by_person_ms = Counter[str]()
        self._by_address_ms = Counter[str]()
        self._last_s: dict[str, float] = {}  # when each person's newest turn ended

    def record(self, person: Person, begun_s: float, ended_s: float) -> None:
        """Record a finished turn."""
        self._expire(ended_s)
        end_s = math.ceil(ended_s / _MINUTE_S) * _MINUTE_S
        if not self._minutes or self._minutes[-1].end_s < end_s:
            self._minutes.append(_Minute(end_s))
        driven_ms = round((ended_s - begun_s) * 1000)
        self._minutes[-1].driven_ms[person.key, person.address] += driven_ms
        self._by_person_ms[person.key] += driven_ms
        self._by_address_ms[person.address] += driven_ms
        self._all_ms += driven_ms
        self._last_s[person.key] = ended_s

    def _expire(self, now_s: float) -> None:
        while self._minutes and self._minutes[0].end_s <= now_s - WINDOW_S:
            for (key, address), driven_ms in self._minutes.popleft().driven_ms.items():
                _subtract(self._by_person_ms, key, driven_ms)
                _subtract(self._by_address_ms, address, driven_ms)
                self._all_ms -= driven_ms
                if self._last_s.get(key, math.inf) <= now_s - WINDOW_S:
                    del self._last_s[key]

    def rank(self, person: Person, now_s: float) -> tuple[bool, bool, bool]:
        """Return a sort key, lowest first: after cool-down, invited, within their share."""
        return (
            self.is_cooling_down(person, now_s),
            self._settings.invited_first and not person.is_invited,
            self._is_over_share(person, now_s),
        )

    def may_be_overtaken(self, person: Person, now_s: float) -> bool:
        """Whether somebody who came later may go first."""
        return self.is_cooling_down(person, now_s) or self._is_over_share(person, now_s)

    def is_cooling_down(self, person: Person, now_s: float) -> bool:
        """Whether the cool-down after this person's last turn still lasts."""
        return now_s < self._last_s.get(person.key, -math.inf) + self._settings.cooldown_s

    def _is_over_share(self, person: Person, now_s: float) -> bool:
        shares = self._settings.max_share_per_person, self._settings.max_share_per_address
        if shares == (1.0, 1.0):
            return False
        self._expire(now_s)
        own_ms, near_ms = self._by_person_ms[person.key], self._by_address_ms[person.address]
        return own_ms > shares[0] * self._all_ms or near_ms > shares[1] * self._all_ms


def _subtract(from_ms: Counter[str], key: str, driven_ms: int) -> None:
    from_ms[key] -= driven_ms
    if not from_ms[key]:
        del from_ms[key]
