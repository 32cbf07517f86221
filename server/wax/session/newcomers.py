"""Whose offer is answered next while more newcomers ask than can be answered. Pure.

Half of the answers are for the addresses that have waited longest, asking again as told, and half
for those that came last. So neither those who ask once, nor those who have asked all the
time, keep out somebody who comes after them. In both orders networks take turns, since one sender
may have all addresses of a network.
"""

from __future__ import annotations

import ipaddress
from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from wax.bounded_dict import BoundedDict

if TYPE_CHECKING:
    from collections.abc import Callable

_WAITS_S: Final = 1.5
"""How long an address goes before others after it has asked; most pages ask again within this."""
_KEEPS_S: Final = 4.0
"""Whoever asks again within this has waited since before: a page does after 1.2 s, two round trips
and 2 s for its candidates."""
_NEW_AGAIN_S: Final = 60.0
_MOST: Final = 4096
_NETWORK_BITS: Final = {4: 24, 6: 48}


@dataclass(slots=True)
class _Newcomer:
    network: str
    came_s: float
    """When it asked for the first time."""
    since_s: float
    """Since when it has asked again and again."""
    asked_s: float
    """When it asked last."""
    waits: bool = True


class Newcomers:
    """The addresses that have asked lately; all times in seconds of one clock."""

    def __init__(self) -> None:
        self._asked = BoundedDict[str, _Newcomer](_MOST)
        self._is_for_last = False
        """Whether the odd one of the answers is for whoever came last."""

    def has_turn(self, address: str, answers: int, now_s: float) -> bool:
        """Whether an address that asks now gets one of so many answers; if so, it took one."""
        own = self._asked.get(address)
        if own is None or now_s - own.asked_s > _NEW_AGAIN_S:
            own = _Newcomer(_network(address), now_s, now_s, now_s)
        elif not own.waits or now_s - own.asked_s > _KEEPS_S:
            own.since_s = now_s
        own.asked_s, own.waits = now_s, True
        self._asked[address] = own
        # Each half is kept until the one whose turn it is asks, however often others ask before.
        for_longest = (answers + (not self._is_for_last)) // 2
        for_last = answers - for_longest
        if self._is_among(for_longest, own, lambda one: one.since_s < own.since_s):
            self._is_for_last = True
        elif self._is_among(for_last, own, lambda one: one.came_s > own.came_s):
            self._is_for_last = False
        else:
            return False
        own.waits = False
        return True

    def forget(self, address: str) -> None:
        """Note that somebody of this address is in: the next one is new again."""
        self._asked.pop(address, None)

    def _is_among(self, first: int, own: _Newcomer, precedes: Callable[[_Newcomer], bool]) -> bool:
        """Whether `own` is among the `first` who wait; networks take turns in each round."""
        if first < 1:
            return False
        waiting, before = Counter[str](), Counter[str]()
        for one in reversed(self._asked.values()):  # those who asked last
            if own.asked_s - one.asked_s > _WAITS_S:
                break
            if one.waits:
                waiting[one.network] += 1
                if precedes(one):
                    before[one.network] += 1
                    if len(before) > first:  # each other network has one turn before this address
                        return False
        rounds = before[own.network]
        del waiting[own.network]
        others = (
            min(number, rounds) + (before[network] > rounds) for network, number in waiting.items()
        )
        return rounds + sum(others) < first


def _network(address: str) -> str:
    try:
        found = ipaddress.ip_interface(address)
    except ValueError:
        return address
    return str(ipaddress.ip_network((found.ip, _NETWORK_BITS[found.version]), strict=False))
