"""Which offers are answered: how many may connect at once, and how many may stay. Pure.

Answering an offer costs time and memory before anything is known about its sender. Each answer
takes a silent place, until its viewer connects or for ten seconds, whatever becomes of the viewer.
When all silent places are taken, a newcomer takes over the oldest one; when those of their address
are, the oldest of that address. So one address costs no more than two answers in three seconds, and
an honest newcomer gets in by then. An address that abandoned an answered offer ranks behind all
others for a minute; such addresses share a quarter of the silent places and of the answers. Among
all others, `Newcomers` decides who is next. The host always gets in, and a returning operator comes
first.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from math import ceil
from typing import TYPE_CHECKING, Final, NamedTuple

from wax.bounded_dict import BoundedDict
from wax.errors import FullError, NoPlaceError, TooOftenError
from wax.rate_limits import TokenBucket
from wax.sentence import Sentence
from wax.session.newcomers import Newcomers

if TYPE_CHECKING:
    from collections.abc import Iterable

SILENT_S: Final = 10.0
"""How long an answered offer counts as connecting."""
MOST_SILENT: Final = 32
YIELDS_S: Final = 3.0
"""After this, a newcomer may take over the silent place; a page this slow retries by itself."""
_BEHIND: Final = 4
"""Addresses that abandoned offers share one silent place, and one answer, in this many."""
_BEHIND_S: Final = 60.0
"""A page that connects clears its address before that: a school's pages fail now and then."""
_MOST_BEHIND: Final = 1024
_YIELDS_SOON_S: Final = 1.0
"""`YIELDS_S` for the place of such an address, if the newcomer's is not one of them."""
_ANSWERS_HZ: Final = 8.0
_ANSWERS_BURST: Final = 8
"""For newcomers: each answer takes five to ten milliseconds, over many passes of the event loop."""
_RETURNS_HZ: Final = 10.0
_LEAST_PER_ADDRESS: Final = 4
"""A family at one address gets in even where there are few places."""
_EMBEDS: Final = 4
"""All embeds (frames on other sites) share one place, and one answer, in this many: a popular site
neither fills the robot nor keeps others out. An embed leaves when a guest needs its place."""
_EMBED_AGAIN_S: Final = 60
EMBEDS_FULL: Final = Sentence("door.embeds_full")
_MOST_HOSTS: Final = 8
"""This many pages of the host have places beyond everybody's; further ones count as guests."""


@dataclass(frozen=True, slots=True)
class Asking:
    """The sender of an offer; `address` is empty if unknown."""

    address: str
    is_host: bool = False
    has_been_here: bool = False
    drives: bool = False
    is_embed: bool = False


class Displaced(NamedTuple):
    """Who has to leave for a newcomer: the viewer with this number, who is silent; an embed."""

    silent: int | None = None
    an_embed: bool = False


class Capacity:
    """Decides for one room of `most` guests; all times in seconds of one clock."""

    def __init__(
        self, *, most: int, most_silent_per_address: int, share_per_address: float
    ) -> None:
        self._most = most
        self._most_embeds = max(1, most // _EMBEDS)
        self._most_silent = min(MOST_SILENT, max(8, most // 2))
        self._most_silent_per_address = most_silent_per_address
        self._most_per_address = max(_LEAST_PER_ADDRESS, int(most * share_per_address))
        # After an outage everybody returns at once.
        self._returns = TokenBucket(_RETURNS_HZ, max(most, 10))
        self._answers = TokenBucket(_ANSWERS_HZ, _ANSWERS_BURST)
        self._embed_answers = TokenBucket(_ANSWERS_HZ / _EMBEDS, _ANSWERS_BURST // _EMBEDS)
        self._behind_answers = TokenBucket(_ANSWERS_HZ / _BEHIND, _ANSWERS_BURST // _BEHIND)
        self._behind_since_s = BoundedDict[str, float](_MOST_BEHIND)
        self._newcomers = Newcomers()
        self._silent: deque[_Silent] = deque()

    def check(self, asking: Asking, now_s: float, embeds: int = 0) -> None:
        """Raise `TooOftenError` if this address holds all its silent places, all of them recent.

        Raise `NoPlaceError` for an embed if the `embeds` present hold all their places. Cheap.
        """
        if asking.is_host or asking.has_been_here:
            return
        if asking.is_embed and embeds >= self._most_embeds:
            raise NoPlaceError(EMBEDS_FULL, retry_after_s=_EMBED_AGAIN_S)
        if not asking.address:
            return
        self._expire(now_s)
        longest = self._longest_of(asking.address)
        if longest is not None and (rest_s := longest.since_s + YIELDS_S - now_s) > 0:
            raise TooOftenError(Sentence("door.address_crowded"), retry_after_s=ceil(rest_s))

    def admit(
        self, number: int, asking: Asking, present: Iterable[Asking], now_s: float
    ) -> Displaced:
        """Admit the viewer with this number, and return who has to leave.

        `present` are those who hold a place in the room. Raises `FullError` or `TooOftenError`.
        """
        if asking.has_been_here:
            if not (asking.is_host or asking.drives) and not self._returns.take(now_s):
                raise FullError(Sentence("door.all_come_back"))
            return Displaced()
        everybody = list(present)
        self.check(asking, now_s, sum(one.is_embed for one in everybody))
        is_full = self._room_for(asking, everybody)
        if asking.is_host:
            return Displaced(an_embed=is_full)
        if asking.is_embed and self._embed_answers.level(now_s) < 1:
            raise FullError(Sentence("door.crowded"))
        silent = self._make_silent_place(asking.address, now_s)
        if asking.is_embed:
            self._embed_answers.take(now_s)
        # A second offer of the same viewer holds a second place.
        self._silent.append(_Silent(number, asking.address, now_s))
        return Displaced(silent, is_full)

    def connected(self, number: int) -> None:
        """Free the silent places of a viewer who has connected."""
        for one in self._silent:
            if one.number == number:
                self._behind_since_s.pop(one.address, None)
                self._newcomers.forget(one.address)
        self._silent = deque(one for one in self._silent if one.number != number)

    def _room_for(self, asking: Asking, present: list[Asking]) -> bool:
        hosts = sum(one.is_host for one in present)
        if asking.is_host and hosts < _MOST_HOSTS:
            return False
        is_full = len(present) - min(hosts, _MOST_HOSTS) >= self._most
        if is_full and (asking.is_embed or not any(one.is_embed for one in present)):
            raise NoPlaceError(Sentence("door.full", {"n": self._most}), retry_after_s=5)
        if asking.is_host:
            return is_full
        guests = [one for one in present if not one.is_host]
        own = sum(one.address == asking.address for one in guests)
        if asking.address and own >= self._most_per_address:
            raise NoPlaceError(
                Sentence("door.full_for_address", {"n": self._most_per_address}),
                retry_after_s=5,
            )
        return is_full

    def _make_silent_place(self, address: str, now_s: float) -> int | None:
        """Return the number of whoever loses their silent place by that."""
        self._expire(now_s)
        own = self._longest_of(address)
        if own is not None:
            self._behind_since_s[address] = now_s
        if not self._has_turn(address, now_s, own):
            raise FullError(Sentence("door.crowded"))
        longest = own or self._to_evict(now_s, is_behind=self._is_behind(address, now_s))
        if longest is None:
            return None
        self._silent.remove(longest)
        self._behind_since_s[longest.address] = now_s
        return longest.number

    def _has_turn(self, address: str, now_s: float, own: _Silent | None) -> bool:
        """Take an answer if there is one for this address, and a silent place."""
        if self._is_behind(address, now_s):
            longest = own or self._to_evict(now_s, is_behind=True)
            is_kept = longest is not None and now_s - longest.since_s < YIELDS_S
            return not is_kept and self._behind_answers.take(now_s)
        free = self._most_silent - len(self._silent)
        yielding = sum(
            now_s - one.since_s
            >= (_YIELDS_SOON_S if self._is_behind(one.address, now_s) else YIELDS_S)
            for one in self._silent
        )
        answers = min(int(self._answers.level(now_s)), free + yielding)
        return self._newcomers.has_turn(address, answers, now_s) and self._answers.take(now_s)

    def _to_evict(self, now_s: float, *, is_behind: bool) -> _Silent | None:
        """Return the silent place that a newcomer must take over, None if one is free."""
        behind = [one for one in self._silent if self._is_behind(one.address, now_s)]
        if is_behind and len(behind) >= self._most_silent // _BEHIND:
            return behind[0]
        if len(self._silent) < self._most_silent:
            return None
        if not is_behind:
            behind = [one for one in behind if now_s - one.since_s >= _YIELDS_SOON_S]
        return behind[0] if behind else self._silent[0]

    def _is_behind(self, address: str, now_s: float) -> bool:
        since_s = self._behind_since_s.get(address, float("-inf"))
        return bool(address) and now_s - since_s < _BEHIND_S

    def _longest_of(self, address: str) -> _Silent | None:
        """Return the oldest silent place of an address that has all of its own."""
        own = [one for one in self._silent if address and one.address == address]
        return own[0] if len(own) >= self._most_silent_per_address else None

    def _expire(self, now_s: float) -> None:
        while self._silent and now_s - self._silent[0].since_s >= SILENT_S:
            self._behind_since_s[self._silent.popleft().address] = now_s


@dataclass(frozen=True, slots=True, eq=False)
class _Silent:
    number: int
    address: str
    since_s: float
